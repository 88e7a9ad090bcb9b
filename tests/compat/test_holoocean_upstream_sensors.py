"""What HoloOcean's own tests ask of its sensors, written anew from their descriptions."""

import math

import numpy as np
import pytest
from holoocean_env import agent, opened

from pelagos.compat.holoocean.frames import matrix_of

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
LOCATION, ROTATION = {"sensor_type": "LocationSensor"}, {"sensor_type": "RotationSensor"}
TURNS = [(0, 0, 0), (25, -40, 110), (-150, 35, -75)]


def sensor(kind, **configuration):
    return {"sensor_type": kind, "configuration": configuration}


@pytest.mark.parametrize("kind", ["LocationSensor", "DepthSensor"])
def test_a_fall_from_20_m_is_watched_downwards_and_then_settles(kind):
    with opened(agent("UavAgent", [sensor(kind)], location=(0, 0, 20))) as env:
        heights = [env.tick()[kind][-1] for _ in range(85)]
        assert (np.diff(heights) < 0).all()
        for _ in range(160):
            rest = env.tick()[kind][-1]
        assert env.tick()[kind][-1] == pytest.approx(rest, abs=1e-3)


def test_location_is_where_an_agent_was_teleported_to_and_noise_moves_it():
    quiet, noisy = dict(LOCATION, sensor_name="quiet"), dict(sensor("LocationSensor", Sigma=1), sensor_name="noisy")
    with opened(agent("SphereAgent", [quiet, noisy], location=(0.95, -1.75, 0.5))) as env:
        env.agents["auv0"].teleport([7, -3, 4])
        state = env.tick()
        np.testing.assert_allclose(state["quiet"], [7, -3, 4], atol=1e-5)
        assert (state["noisy"] != state["quiet"]).all()


def test_depth_noise_is_on():
    sensors = [dict(sensor("DepthSensor"), sensor_name="quiet"), dict(sensor("DepthSensor", Sigma=1), sensor_name="n")]
    with opened(agent("SphereAgent", sensors, location=(0.95, -1.75, 0.5))) as env:
        states = [env.tick() for _ in range(20)]
        assert np.std([s["n"] - s["quiet"] for s in states]) > 0.3  # of 20 draws of 1: below it once in 1e6
        assert states[0]["n"].shape == (1,)


@pytest.mark.parametrize("turn", TURNS)
def test_orientation_rotation_and_pose_after_a_teleport(turn):
    sensors = [sensor("OrientationSensor"), ROTATION, sensor("PoseSensor"), LOCATION]
    with opened(agent("SphereAgent", sensors, location=(0.95, -1.75, 0.5))) as env:
        env.agents["auv0"].teleport([1, 2, 3], list(turn))
        state = env.tick()
        np.testing.assert_allclose(state["OrientationSensor"], matrix_of(turn), atol=1e-5)
        np.testing.assert_allclose(state["RotationSensor"], turn, atol=1e-4)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = state["OrientationSensor"], state["LocationSensor"]
        np.testing.assert_allclose(state["PoseSensor"], pose, atol=1e-6)


@pytest.mark.parametrize("turn", TURNS)
def test_the_magnetic_vector_is_seen_in_the_sensors_frame(turn):
    magnet = sensor("MagnetometerSensor", MagneticVector=[0.3, -1.2, 2.5])
    with opened(agent("SphereAgent", [magnet], rotation=list(turn))) as env:
        seen = env.tick()["MagnetometerSensor"]
        np.testing.assert_allclose(seen, matrix_of(turn).T @ [0.3, -1.2, 2.5], rtol=1e-3)


def test_magnetometer_noise_is_on():
    with opened(agent("SphereAgent", [sensor("MagnetometerSensor", Sigma=1)])) as env:
        assert (env.tick()["MagnetometerSensor"] != env.tick()["MagnetometerSensor"]).all()


class TestTurtle:
    """Pushed along x on the floor, either way."""

    @staticmethod
    def driven(sensors, force, ticks=30):
        with opened(agent("TurtleAgent", sensors, location=(0, 0, 0.2))) as env:
            env.tick(60)
            states = [env.step([force, 0]) for _ in range(ticks)]
            env.act("auv0", [0, 0])
            return states, env.tick(150), env.tick()

    @pytest.mark.parametrize("force", [100, -100])
    def test_velocities_grow_all_the_while_and_come_to_rest(self, force):
        sensors = [sensor("DVLSensor"), sensor("VelocitySensor"), sensor("DynamicsSensor", UseCOM=True, UseRPY=True)]
        states, _, rest = self.driven(sensors, force)
        for name, x in (("DVLSensor", slice(0, 3)), ("VelocitySensor", slice(0, 3)), ("DynamicsSensor", slice(3, 6))):
            seen = np.array([s[name][x] for s in states])
            assert (np.diff(seen[:, 0]) * np.sign(force) > 0).all(), name
            assert np.abs(seen[:, 1:]).max() <= 0.5, name
            assert np.abs(rest[name][x]).max() <= 1e-2, name

    @pytest.mark.parametrize("force", [25, -25])
    def test_an_imu_feels_the_push_and_gravity(self, force):
        states, _, rest = self.driven([sensor("IMUSensor")], force, ticks=10)
        assert np.sign(states[0]["IMUSensor"][0, 0]) == np.sign(force)
        assert max(abs(s["IMUSensor"][0, 1]) for s in states) <= 0.5
        assert rest["IMUSensor"].shape == (2, 3)
        assert rest["IMUSensor"][0, 2] == pytest.approx(9.81, rel=0.01)
        np.testing.assert_allclose(rest["IMUSensor"][1], 0, atol=1e-2)

    @pytest.mark.parametrize("turn", [25, -25])
    def test_a_gyroscope_feels_the_turn(self, turn):
        with opened(agent("TurtleAgent", [sensor("IMUSensor"), ROTATION], location=(0, 0, 0.2))) as env:
            env.tick(60)
            state = env.step([0, turn], ticks=10)
            assert np.sign(state["IMUSensor"][1, 2]) == np.sign(turn)
            assert np.sign(state["RotationSensor"][2]) == np.sign(turn)


def test_an_imu_returns_biases_which_are_zero_without_their_noise():
    quiet = dict(sensor("IMUSensor", ReturnBias=True, AccelSigma=0.1, AngVelSigma=0.1), sensor_name="quiet")
    walking = dict(
        sensor("IMUSensor", ReturnBias=True, AccelBiasSigma=0.1, AngVelBiasCov=[0.01, 0.02, 0.03]), sensor_name="w"
    )
    with opened(agent("SphereAgent", [quiet, walking])) as env:
        env.tick(20)
        state = env.tick()
        assert state["quiet"].shape == (4, 3)
        assert not state["quiet"][2:].any()
        assert state["w"][2:].all()


@pytest.mark.parametrize("rpy", [True, False])
def test_a_dynamics_sensor_has_18_numbers_or_19(rpy):
    with opened(agent("HoveringAUV", [sensor("DynamicsSensor", UseRPY=rpy)])) as env:
        assert env.tick()["DynamicsSensor"].shape == (18 if rpy else 19,)


def test_gps_is_there_above_its_depth_and_absent_below():
    gps = sensor("GPSSensor", Depth=1)
    with opened(agent("SphereAgent", [gps], location=(0, -50, -0.5))) as env:
        np.testing.assert_allclose(env.tick()["GPSSensor"], [0, -50, -0.5], atol=1e-5)
        env.agents["auv0"].teleport([0, -50, -1.5])
        assert "GPSSensor" not in env.tick()
        env.tide(1, 0)  # the level rises by 1 m
        env.agents["auv0"].teleport([0, -50, -0.5])
        assert "GPSSensor" not in env.tick()


@pytest.mark.parametrize(("depth", "p"), [(-0.5, 5.7e-7), (-1.0 + 0.1, 0.1587)])
def test_the_gate_of_a_gps_is_noisy(depth, p):
    """1000 draws of N(0, sigma) against the distance to the gate; within 5 sigma of the binomial count."""
    sigma = (1 + depth) / (4.87 if p < 1e-3 else 1.0)  # upper tails of 5.7e-7 and of 0.1587
    with opened(
        agent("SphereAgent", [sensor("GPSSensor", Depth=1, DepthSigma=sigma)], location=(0, -50, depth))
    ) as env:
        lost = sum("GPSSensor" not in env.tick() for _ in range(1000))
    assert abs(lost - 1000 * p) <= 5 * math.sqrt(1000 * p * (1 - p)) + 1


MVN = [
    ("LocationSensor", "", 3), ("DepthSensor", "", 1), ("MagnetometerSensor", "", 3), ("DVLSensor", "Vel", 4),
    ("IMUSensor", "Accel", 3),
]  # fmt: skip


FORMS = ("Sigma", "Sigmas", "Cov", "Covs", "matrix")


def noise(form, size):
    """What is given in that form, and the covariance that it means."""
    root = np.tril(np.arange(1.0, 1 + size * size).reshape(size, size)) / size**2 + 0.5 * np.eye(size)
    row = np.arange(1.0, size + 1)
    return {
        "Sigma": (2.0, 4.0 * np.eye(size)), "Sigmas": (list(row), np.diag(row**2)), "Cov": (3.0, 3.0 * np.eye(size)),
        "Covs": (list(row), np.diag(row)), "matrix": ((root @ root.T).tolist(), root @ root.T),
    }[form]  # fmt: skip


@pytest.fixture(scope="module")
def draws():
    """400 states of one agent with a quiet sensor of each kind and noisy ones of every form."""
    sensors = [dict(sensor(kind), sensor_name=f"{kind} quiet") for kind, _, _ in MVN]
    for kind, prefix, size in MVN:
        for form in FORMS:
            key = prefix + ("Sigma" if form.startswith("Sigma") else "Cov")
            sensors.append(dict(sensor(kind, **{key: noise(form, size)[0]}), sensor_name=f"{kind} {form}"))
    with opened(agent("SphereAgent", sensors), seed=3) as env:
        return [env.tick() for _ in range(400)]


@pytest.mark.parametrize(("kind", "size"), [(kind, size) for kind, _, size in MVN])
@pytest.mark.parametrize("form", FORMS)
def test_noise_has_the_covariance_that_was_given(draws, kind, size, form):
    covariance = noise(form, size)[1]
    errors = np.array([np.ravel(s[f"{kind} {form}"] - s[f"{kind} quiet"])[: min(size, 3)] for s in draws])
    if size == 4:  # beams to axes
        sine, cosine = np.sin(np.radians(22.5)), np.cos(np.radians(22.5))
        mix = np.array([[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]]) / (2 * sine)
        mix[2] = 1 / (4 * cosine)
        covariance = mix @ covariance @ mix.T
    found = errors.T @ errors / len(errors)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    # a sample covariance of n draws has a standard error of sqrt((1 + r^2) / n) of the scale: 5 of them
    assert (np.abs(found - covariance) <= 5 * math.sqrt(2 / 400) * scale).all()


def test_twelve_lasers_meet_nothing_and_one_meets_what_comes_near():
    lasers = sensor("RangeFinderSensor", LaserMaxDistance=1, LaserCount=12)
    with opened(agent("SphereAgent", [lasers], location=(0.95, -1.75, 0.5))) as env:
        np.testing.assert_array_equal(env.tick()["RangeFinderSensor"], [-1] * 12)
    one = sensor("RangeFinderSensor", LaserMaxDistance=1)
    with opened(agent("SphereAgent", [one], location=(0.95, 0.7, 0.5), scheme=1)) as env:
        seen = [float(env.step([0.05, 0])["RangeFinderSensor"][0]) for _ in range(30)]
        assert seen[0] == -1
        met = np.array([s for s in seen if s >= 0])
        assert len(met) > 3
        assert ((met >= 0) & (met <= 1)).all()


def test_a_laser_downwards_falls_and_settles():
    down = sensor("RangeFinderSensor", LaserMaxDistance=100, LaserAngle=-90)
    with opened(agent("UavAgent", [down], location=(0, 0, 10))) as env:
        seen = [float(env.tick()["RangeFinderSensor"][0]) for _ in range(250)]
        assert (np.diff(seen[:40]) < 0).all()
        assert np.ptp(seen[-5:]) < 1e-3
        assert seen[0] == pytest.approx(10, abs=0.5)


def test_a_sensor_of_15_hz_is_there_at_every_second_tick():
    with opened(agent("SphereAgent", [dict(LOCATION, Hz=15)]), ticks_per_sec=30) as env:
        assert ["LocationSensor" in env.tick() for _ in range(8)] == [True, False] * 4


def test_velocity_falls_rests_and_rises_at_a_thrust_of_1000():
    with opened(agent("UavAgent", [sensor("VelocitySensor")], location=(0, 0, 10))) as env:
        falling = [env.tick()["VelocitySensor"][2] for _ in range(30)]
        assert (np.diff(falling) < 0).all()
        env.tick(250)
        assert abs(env.tick()["VelocitySensor"][2]) < 1e-2
        rising = [env.step([0, 0, 0, 1000])["VelocitySensor"][2] for _ in range(10)]
        assert rising[-1] > rising[0] > 0


def test_a_collision_is_felt_from_the_landing_until_the_lift():
    with opened(agent("UavAgent", [sensor("CollisionSensor"), LOCATION], location=(0, 0, 3))) as env:
        state = env.tick()
        assert state["CollisionSensor"].dtype == np.bool_
        assert state["CollisionSensor"].shape == (1,)
        assert not state["CollisionSensor"][0]
        env.tick(120)
        assert all(env.tick()["CollisionSensor"][0] for _ in range(30))
        env.step([0, 0, 0, 1000], ticks=10)
        assert not env.tick()["CollisionSensor"][0]


@pytest.mark.parametrize("kind", ["UavAgent", "TurtleAgent"])
def test_lying_on_the_back_is_abuse(kind):
    with opened(agent(kind, [sensor("AbuseSensor")], location=(0, 0, 1))) as env:
        assert env.tick()["AbuseSensor"].dtype == np.int8
        assert not env.tick()["AbuseSensor"][0]
        env.agents["auv0"].teleport([0, 0, 1], [180, 0, 0])
        assert any(env.tick()["AbuseSensor"][0] for _ in range(5))


class TestLidar:
    SITE = (-6.5, -30, 5)

    def clouds(self, ticks, hz=30, **keys):
        lidar = dict(sensor("RaycastLidar", Channels=32, Range=200, PointsPerSecond=20000, **keys), Hz=hz)
        with opened(agent("SphereAgent", [lidar], location=self.SITE), ticks_per_sec=30) as env:
            return [env.tick()["RaycastLidar"] for _ in range(ticks)]

    def test_without_dropping_off_scans_are_alike(self):
        scans = self.clouds(5, hz=30, RotationFrequency=30, DropOffGenRate=0, DropOffAtZeroIntensity=1)
        for scan in scans[1:]:
            np.testing.assert_allclose(scan, scans[0], atol=1e-4)
        assert scans[0].shape[1] == 5
        assert len(scans[0]) > 50

    @pytest.mark.parametrize("fov", [360, 180, 90])
    def test_there_are_points_for_every_field_of_view(self, fov):
        scan = self.clouds(1, HorizontalFov=fov, RotationFrequency=30)[0]
        assert len(scan)
        if fov < 360:
            bearing = np.degrees(np.arctan2(scan[:, 1], scan[:, 0]))
            assert np.abs(bearing).max() <= fov / 2 + 1e-3

    def test_at_10_hz_two_of_six_ticks_bring_a_scan(self):
        assert [len(scan) > 0 for scan in self.clouds(6, hz=10)] == [True, False, False] * 2


def test_the_centre_of_a_depth_camera_is_two_metres_away():
    eye = dict(sensor("DepthCamera", CaptureWidth=256, CaptureHeight=256), socket="CameraSocket")
    with opened(agent("SphereAgent", [eye], location=(0.77, 0.9, 0.5))) as env:
        seen = env.tick()["DepthCamera"]
        assert seen["depth"][128, 128] == pytest.approx(2.0, rel=0.01)
        assert seen["depth"].shape == (256, 256)
        assert seen["depth"].dtype == np.float64
        blue, green, red, _ = (int(v) for v in seen["image"][128, 128])
        assert 1000 * (red + 256 * green + 65536 * blue) / (2**24 - 1) == seen["depth"][128, 128]
