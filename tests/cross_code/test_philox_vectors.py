"""Philox4x32-10 against the known-answer vectors of Random123 1.14.0 (file `kat_vectors`), its authors' own library."""

import numpy as np
import pytest

from pelagos import jit
from pelagos.math.philox import philox

VECTORS = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]


@pytest.mark.parametrize(("counter", "key", "expected"), VECTORS)
def test_known_answers(counter: str, key: str, expected: str) -> None:
    c, k, e = ([int(word, 16) for word in text.split()] for text in (counter, key, expected))
    words = philox(tuple(jit.UInt32(x) for x in c), tuple(jit.UInt32(x) for x in k))
    assert [int(np.array(w)[0]) for w in words] == e
