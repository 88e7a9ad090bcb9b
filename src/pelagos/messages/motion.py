"""The vehicle's true motion, its frames and its plan: Odometry, /tf, /tf_static, Path (world ENU, body FLU)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.frames import nwu_to_enu_np, quaternion_nwu_to_enu_np
from pelagos.messages.store import Message, header, make, quaternion, serialize, stamp, vector3
from pelagos.messages.template import STAMP, Buffer, Template, fields, joined

ODOMETRY: Final = "nav_msgs/msg/Odometry"
PATH: Final = "nav_msgs/msg/Path"
TF: Final = "tf2_msgs/msg/TFMessage"
WORLD_FRAME: Final = "map"

ODOMETRY_FIELDS: Final = joined(
    STAMP, fields("pose.pose.position", "x y z"), fields("pose.pose.orientation", "x y z w"),
    fields("twist.twist.linear", "x y z"), fields("twist.twist.angular", "x y z"),
)  # fmt: skip


class TruthEncoder:
    """Odometry and transform of one vehicle.

    Attributes:
        odometry: template of its odometry, whose numbers behind the stamp are those of `numbers`.
        transform: template of its transform, whose numbers are the first seven.
    """

    def __init__(self, base_frame: str) -> None:
        self.odometry = Template(ODOMETRY, _odometry(base_frame), ODOMETRY_FIELDS)
        message = make(TF, transforms=[_transform(WORLD_FRAME, base_frame, (0, 0, 0), (1, 0, 0, 0))])
        inside = [f"transforms[0].{field}" for field in STAMP]
        inside += fields("transforms[0].transform.translation", "x y z")
        inside += fields("transforms[0].transform.rotation", "x y z w")
        self.transform = Template(TF, message, inside)

    @staticmethod
    def numbers(
        position: NDArray[np.float64],
        attitude: NDArray[np.float64],
        velocity: NDArray[np.float64],
        angular_velocity: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """`(k, 13)`: position ENU and quaternion xyzw, and both velocities, of one copy at k times.

        Args:
            position: `(k, 3)` NWU [m].
            attitude: `(k, 4)` wxyz.
            velocity, angular_velocity: `(k, 3)` FLU [m/s], [rad/s].
        """
        return np.concatenate([_poses(position, attitude), velocity, angular_velocity], axis=1)

    def transforms(self, t_ns: NDArray[np.int64], numbers: NDArray[np.float64]) -> NDArray[np.uint8]:
        """`(k, size)` bytes of transforms at k times [ns] `(k,)`."""
        return self.transform.rows(t_ns, numbers[:, :7])

    def encode(
        self,
        t_ns: int,
        position: NDArray[np.float64],
        attitude: NDArray[np.float64],
        velocity: NDArray[np.float64],
        angular_velocity: NDArray[np.float64],
    ) -> tuple[Buffer, Buffer]:
        """One odometry and one transform: `(3,)`, `(4,)`, `(3,)`, `(3,)`, see `numbers`."""
        pose = (*divmod(t_ns, 1_000_000_000), *_poses(position, attitude).tolist())
        return (
            self.odometry.encode(*pose, *velocity.tolist(), *angular_velocity.tolist()),
            self.transform.encode(*pose),
        )


def _poses(position: NDArray[np.float64], attitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(..., 7)` position ENU and quaternion xyzw, of position NWU and quaternion wxyz."""
    q = quaternion_nwu_to_enu_np(attitude)
    return np.concatenate([nwu_to_enu_np(position), q[..., 1:], q[..., :1]], axis=-1)


def path_message(corners: NDArray[np.float64]) -> bytes:
    """nav_msgs/Path in `map` through corners `(k, 3)` NWU [m]; each pose looks along the way that leads to it."""
    step = np.diff(corners, axis=0, prepend=corners[:1])
    if len(step) > 1:
        step[0] = step[1]
    poses = []
    yaw = 0.0
    for corner, ahead in zip(corners, step, strict=True):
        if np.hypot(ahead[0], ahead[1]) > 0:
            yaw = float(np.arctan2(ahead[1], ahead[0]))
        q = quaternion_nwu_to_enu_np(np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]))
        east, north, up = nwu_to_enu_np(corner).tolist()
        pose = make(
            "geometry_msgs/msg/Pose",
            position=make("geometry_msgs/msg/Point", x=east, y=north, z=up),
            orientation=quaternion(*q.tolist()),
        )
        poses.append(make("geometry_msgs/msg/PoseStamped", header=header(WORLD_FRAME), pose=pose))
    return serialize(PATH, make(PATH, header=header(WORLD_FRAME), poses=poses))


def static_transform(
    parent: str, child: str, *, position: Sequence[float] = (0.0, 0.0, 0.0), attitude: Sequence[float]
) -> Message:
    """Pose of a fixed frame in another: position [m] and quaternion wxyz, child to parent."""
    return _transform(parent, child, position, attitude)


def static_message(transforms: list[Message]) -> bytes:
    """The one latched message on /tf_static."""
    return serialize(TF, make(TF, transforms=transforms))


def _transform(parent: str, child: str, position: Sequence[float], attitude: Sequence[float]) -> Message:
    transform = make(
        "geometry_msgs/msg/Transform",
        translation=vector3(*(float(p) for p in position)),
        rotation=quaternion(*(float(q) for q in attitude)),
    )
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=make("std_msgs/msg/Header", stamp=stamp(0), frame_id=parent),
        child_frame_id=child,
        transform=transform,
    )


def _odometry(base_frame: str) -> Message:
    pose = make(
        "geometry_msgs/msg/Pose",
        position=make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0),
        orientation=quaternion(),
    )
    twist = make("geometry_msgs/msg/Twist", linear=vector3(), angular=vector3())
    return make(
        ODOMETRY,
        header=header(WORLD_FRAME),
        child_frame_id=base_frame,
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36)),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
    )
