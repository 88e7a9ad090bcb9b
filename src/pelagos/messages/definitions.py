"""Interface texts of message packages that are not part of a ROS 2 distribution's common interfaces.

Field names, types and constants are those of marine_acoustic_msgs 2.1 (Applied Physics Laboratory, University of
Washington), so that its readers understand our recordings; https://docs.ros.org/en/jazzy/p/marine_acoustic_msgs
For instruments that sample the water no package has messages; pelagos_msgs is our own.
"""

from __future__ import annotations

from typing import Final

PING_INFO: Final = """
float32 frequency
float32 sound_speed
float32[] tx_beamwidths
float32[] rx_beamwidths
"""

DETECTION_FLAG: Final = """
uint8 DETECT_OK = 0
uint8 DETECT_BAD_SONAR = 1
uint8 DETECT_BAD_FILTER = 2
uint8 DETECT_BAD_USER = 4
uint8 flag
"""

SONAR_IMAGE_DATA: Final = """
bool is_bigendian
uint32 DTYPE_UINT8 = 0
uint32 DTYPE_INT8 = 1
uint32 DTYPE_UINT16 = 2
uint32 DTYPE_INT16 = 3
uint32 DTYPE_UINT32 = 4
uint32 DTYPE_INT32 = 5
uint32 DTYPE_UINT64 = 6
uint32 DTYPE_INT64 = 7
uint32 DTYPE_FLOAT32 = 8
uint32 DTYPE_FLOAT64 = 9
uint32 dtype
uint32 beam_count
uint8[] data
"""

PROJECTED_SONAR_IMAGE: Final = """
std_msgs/Header header
PingInfo ping_info
geometry_msgs/Vector3[] beam_directions
float32[] ranges
SonarImageData image
"""

RAW_SONAR_IMAGE: Final = """
std_msgs/Header header
PingInfo ping_info
float32 sample_rate
uint32 samples_per_beam
uint32 sample0
float32[] tx_delays
float32[] tx_angles
float32[] rx_angles
SonarImageData image
"""

SONAR_RANGES: Final = """
std_msgs/Header header
PingInfo ping_info
DetectionFlag[] flags
float32[] transmit_delays
float32[] intensities
geometry_msgs/Vector3[] beam_unit_vec
float32[] ranges
"""

SONAR_DETECTIONS: Final = """
std_msgs/Header header
PingInfo ping_info
DetectionFlag[] flags
float32[] two_way_travel_times
float32[] tx_delays
float32[] intensities
float32[] tx_angles
float32[] rx_angles
"""

DVL: Final = """
uint8 DVL_MODE_BOTTOM=1
uint8 DVL_MODE_WATER=2
uint8 DVL_TYPE_PISTON=0
uint8 DVL_TYPE_PHASED_ARRAY=1
std_msgs/Header header
uint8 velocity_mode
uint8 dvl_type
geometry_msgs/Vector3 velocity
float64[9] velocity_covar
float64 altitude
float64 course_gnd
float64 speed_gnd
uint8 num_good_beams
float32 sound_speed
bool beam_ranges_valid
bool beam_velocities_valid
geometry_msgs/Vector3[4] beam_unit_vec
float64[4] range
float32[4] range_covar
float32[4] beam_quality
float32[4] beam_velocity
float32[4] beam_velocity_covar
"""

CTD: Final = """
# What a CTD says, in the water at its inlet
std_msgs/Header header
float64 conductivity  # S/m
float64 temperature   # in situ, ITS-90, degC
float64 pressure      # of the sea, without the atmosphere's, dbar
float64 salinity      # practical, PSS-78
float64 sound_speed   # m/s
"""

WATER_PROPERTY: Final = """
# One quantity of the water at a sensor
std_msgs/Header header
string quantity   # such as oxygen, chlorophyll, turbidity, sound_speed, or a tracer's name
string unit       # of value; empty where the tracer's is the scenario's own
float64 value
float64 variance  # of one reading, in the unit squared; 0 where unknown
"""

GROUP_READINGS: Final = """
# Readings of a group's members at one time: a row of numbers each
std_msgs/Header header             # frame_id: the group's sensor
bool[] valid                       # by member: whose reading is here; rows of the others are zero
std_msgs/MultiArrayLayout layout   # members, and the names of the numbers as fields of the members' own message type
float64[] data                     # (members, numbers)
"""

PACKAGES: Final = {
    "pelagos_msgs/msg/GroupReadings": GROUP_READINGS,
    "pelagos_msgs/msg/Ctd": CTD,
    "pelagos_msgs/msg/WaterProperty": WATER_PROPERTY,
    "marine_acoustic_msgs/msg/PingInfo": PING_INFO,
    "marine_acoustic_msgs/msg/DetectionFlag": DETECTION_FLAG,
    "marine_acoustic_msgs/msg/SonarImageData": SONAR_IMAGE_DATA,
    "marine_acoustic_msgs/msg/ProjectedSonarImage": PROJECTED_SONAR_IMAGE,
    "marine_acoustic_msgs/msg/RawSonarImage": RAW_SONAR_IMAGE,
    "marine_acoustic_msgs/msg/SonarRanges": SONAR_RANGES,
    "marine_acoustic_msgs/msg/SonarDetections": SONAR_DETECTIONS,
    "marine_acoustic_msgs/msg/Dvl": DVL,
}
