"""Speed as a first-class command: cases declared as data, beside published figures and limits of the same run."""
