"""Other people's DDS: a subscriber in C++ on Fast DDS, which every ROS 2 distribution ships, and tshark's dissector.

Neither comes from a Python index: `sh scripts/peers.sh` installs both (Debian 12: Fast DDS 2.9.1, tshark 4.0). Skipped
where they are missing.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pelagos.bridges.transport import Qos
from pelagos.messages.store import header, make, quaternion, serialize, stamp, vector3

pytest.importorskip("cyclonedds")

from pelagos.bench import ros2_peer
from pelagos.bridges.dds import DdsTransport
from pelagos.bridges.rihs import type_hash

DOMAIN = 100 + os.getpid() % 60
IMU = "sensor_msgs/msg/Imu"
IMAGE = "sensor_msgs/msg/Image"
PIXELS = (np.arange(300 * 1001) * 7919 % 251).astype(np.uint8)
COUNT = 50
PEER = Path(ros2_peer.__file__)

IDL = """
module builtin_interfaces { module msg { module dds_ {
  struct Time_ { long sec; unsigned long nanosec; };
}; }; };
module std_msgs { module msg { module dds_ {
  struct Header_ { builtin_interfaces::msg::dds_::Time_ stamp; string frame_id; };
}; }; };
module geometry_msgs { module msg { module dds_ {
  struct Quaternion_ { double x; double y; double z; double w; };
  struct Vector3_ { double x; double y; double z; };
}; }; };
module sensor_msgs { module msg { module dds_ {
  struct Imu_ {
    std_msgs::msg::dds_::Header_ header;
    geometry_msgs::msg::dds_::Quaternion_ orientation;
    double orientation_covariance[9];
    geometry_msgs::msg::dds_::Vector3_ angular_velocity;
    double angular_velocity_covariance[9];
    geometry_msgs::msg::dds_::Vector3_ linear_acceleration;
    double linear_acceleration_covariance[9];
  };
  struct Image_ {
    std_msgs::msg::dds_::Header_ header;
    unsigned long height;
    unsigned long width;
    string encoding;
    octet is_bigendian;
    unsigned long step;
    sequence<octet> data;
  };
}; }; };
"""

SUBSCRIBER = """
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include "ImuPubSubTypes.h"
using namespace eprosima::fastdds::dds;
DataReader* read(DomainParticipant* participant, Subscriber* subscriber, const char* name, TypeSupport type) {
  type.register_type(participant);
  auto topic = participant->create_topic(name, type.get_type_name(), TOPIC_QOS_DEFAULT);
  DataReaderQos qos = DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().kind = KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 100;
  return subscriber->create_datareader(topic, qos);
}
int main(int, char** argv) {
  auto participant = DomainParticipantFactory::get_instance()->create_participant(
      std::atoi(argv[1]), PARTICIPANT_QOS_DEFAULT);
  TypeSupport type(new sensor_msgs::msg::dds_::Imu_PubSubType());
  TypeSupport picture(new sensor_msgs::msg::dds_::Image_PubSubType());
  auto subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  auto reader = read(participant, subscriber, "rt/rov/imu", type);
  auto pictures = read(participant, subscriber, "rt/rov/image", picture);
  std::printf("ready %s\\n", type.get_type_name().c_str());
  std::fflush(stdout);
  sensor_msgs::msg::dds_::Imu_ m;
  SampleInfo info;
  for (int count = 0; count < std::atoi(argv[2]);) {
    if (!reader->wait_for_unread_message({30, 0})) return 1;
    while (reader->take_next_sample(&m, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      ++count;
      std::printf("%s %d %u %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\\n", m.header().frame_id().c_str(),
                  m.header().stamp().sec(), m.header().stamp().nanosec(), m.angular_velocity().x(),
                  m.angular_velocity().y(), m.angular_velocity().z(), m.linear_acceleration().x(),
                  m.linear_acceleration().y(), m.linear_acceleration().z(), m.orientation().w(),
                  m.linear_acceleration_covariance()[8]);
      std::fflush(stdout);
    }
  }
  sensor_msgs::msg::dds_::Image_ image;
  for (bool got = false; !got;) {
    if (!pictures->wait_for_unread_message({30, 0})) return 2;
    while (pictures->take_next_sample(&image, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      unsigned long sum = 0;
      for (unsigned char byte : image.data()) sum = (sum * 31 + byte) % 1000003;
      std::printf("image %u %u %zu %lu\\n", image.height(), image.width(), image.data().size(), sum);
      got = true;
    }
  }
  return 0;
}
"""


def needs(*programs: str) -> None:
    lacking = [p for p in programs if shutil.which(p) is None]
    if lacking:
        pytest.skip(f"{', '.join(lacking)} not installed: sh scripts/peers.sh")


def imu(number: int) -> bytes:
    message = make(
        IMU,
        header=header("rov/imu"),
        orientation=quaternion(),
        orientation_covariance=np.arange(9.0),
        angular_velocity=vector3(0.1 * number, -0.25, 1.0 / 3.0),
        angular_velocity_covariance=np.arange(9.0),
        linear_acceleration=vector3(-2.5, 0.5 * number, 9.81),
        linear_acceleration_covariance=np.arange(9.0) + 0.125,
    )
    message.header.stamp = stamp(3_000_000_007 + number * 10_000_000)
    return bytes(serialize(IMU, message))


def image() -> bytes:
    """A picture of five datagrams of the loopback."""
    about = {"height": 300, "width": 1001, "encoding": "mono8", "is_bigendian": 0, "step": 1001}
    return bytes(serialize(IMAGE, make(IMAGE, header=header("rov/camera"), data=PIXELS, **about)))


@pytest.mark.slow  # its compiler; `make test-all` installs it. On Cyclone DDS: tests/unit/test_bridge_dds.py
def test_a_subscriber_in_cpp_reads_every_number_and_pixel(tmp_path: Path) -> None:
    needs("g++", "fastddsgen", "java")
    (tmp_path / "Imu.idl").write_text(IDL)
    (tmp_path / "main.cpp").write_text(SUBSCRIBER)
    made = subprocess.run(["fastddsgen", "-replace", "Imu.idl"], cwd=tmp_path, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr
    sources = [p.name for p in tmp_path.glob("Imu*.cxx")]
    built = subprocess.run(
        ["g++", "-std=c++17", "-O0", "-w", *sources, "main.cpp", "-o", "peer", "-lfastrtps", "-lfastcdr"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    if "fastdds/dds" in built.stderr and "No such file" in built.stderr:
        pytest.skip("Fast DDS's headers are not installed (libfastrtps-dev)")
    assert built.returncode == 0, built.stderr
    transport = DdsTransport(domain=DOMAIN, node="sim")
    write = transport.advertise("/rov/imu", IMU, qos=Qos(depth=100))
    show = transport.advertise("/rov/image", IMAGE, qos=Qos(depth=5, large=True))
    picture = image()
    peer = subprocess.Popen([tmp_path / "peer", str(DOMAIN), str(COUNT)], stdout=subprocess.PIPE, text=True)
    try:
        assert peer.stdout is not None
        assert peer.stdout.readline().split() == ["ready", "sensor_msgs::msg::dds_::Imu_"]
        number, end = 0, time.monotonic() + 60
        while peer.poll() is None and time.monotonic() < end:
            write(imu(number), 0)
            number += 1
            if number % 50 == 0:
                show(picture, 0)
            time.sleep(0.01)
        lines = [line.split() for line in peer.stdout.read().splitlines()]
        assert peer.poll() == 0
    finally:
        peer.kill()
        peer.wait()
        assert peer.stdout is not None
        peer.stdout.close()
        transport.close()
    shown = [line for line in lines if line[0] == "image"]
    lines = [line for line in lines if line[0] != "image"]
    assert len(lines) == COUNT
    first = round(float(lines[0][3]) / 0.1)
    for at, (frame, *words) in enumerate(lines):
        k = first + at  # none missing
        sec, nanosec = divmod(3_000_000_007 + k * 10_000_000, 1_000_000_000)
        values = [0.1 * k, -0.25, 1.0 / 3.0, -2.5, 0.5 * k, 9.81, 1.0, 8.125]
        assert (frame, int(words[0]), int(words[1])) == ("rov/imu", sec, nanosec)
        assert [float(w) for w in words[2:]] == values
    total = 0
    for byte in PIXELS.tolist():
        total = (total * 31 + byte) % 1000003
    assert shown[0] == ["image", "300", "1001", str(len(PIXELS)), str(total)]


def test_tshark_names_topic_type_and_encoding(tmp_path: Path) -> None:
    needs("tshark")
    capture, name = tmp_path / "wire.pcap", "std_msgs/msg/String"
    sniffer = subprocess.Popen(
        ["tshark", "-i", "lo", "-f", "udp", "-a", "duration:25", "-w", str(capture)],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert sniffer.stderr is not None
    first = sniffer.stderr.readline() + sniffer.stderr.readline()
    if "permission" in first.lower():
        sniffer.kill()
        pytest.skip("no right to capture on the loopback interface")
    time.sleep(2.0)
    # in another process: within one, nothing goes over the wire
    command = [sys.executable, str(PEER), str(DOMAIN + 60), f"/wire={name}"]
    peer = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    transport = DdsTransport(domain=DOMAIN + 60, node="a")
    try:
        assert peer.stdout is not None
        assert peer.stdout.readline().strip() == "ready"
        write = transport.advertise("/wire", name, qos=Qos())
        for _ in range(60):
            write(serialize(name, make(name, data="over the wire")), 0)
            time.sleep(0.05)
        said, _ = peer.communicate(timeout=60)
    finally:
        peer.kill()
        transport.close()
    time.sleep(1.0)
    sniffer.terminate()
    sniffer.communicate(timeout=30)
    assert json.loads(said)["count"] > 0
    ports = f"udp.port>={7400 + 250 * (DOMAIN + 60)} && udp.port<{7650 + 250 * (DOMAIN + 60)}"
    read = subprocess.run(
        ["tshark", "-r", str(capture), "-Y", f"rtps && {ports}", "-V"], capture_output=True, text=True
    )
    text = read.stdout
    assert "rt/wire" in text
    assert "std_msgs::msg::dds_::String_" in text
    assert "encapsulation kind: CDR_LE" in text
    raw = capture.read_bytes()
    assert f"typehash={type_hash(name)};".encode() in raw
    assert b"enclave=/;" in raw
