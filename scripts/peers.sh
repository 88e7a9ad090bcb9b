#!/bin/sh
# Install through apt what the tests of ROS 2's wire compare with: Fast DDS (a subscriber in C++ is built) and tshark. Those tests are
# skipped without them.
exec sh "$(dirname "$0")/apt.sh" "tests of ROS 2's wire" "tshark fastddsgen java g++" \
    "tshark g++ libfastrtps-dev fastddsgen default-jre-headless"
