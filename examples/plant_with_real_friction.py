"""A plant as a workshop has it: friction that sticks, drives with a current loop and delay, encoders with noise."""

import asmc_pin

arm = asmc_pin.load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
ideal = asmc_pin.Plant(arm, friction=asmc_pin.Friction())
real = asmc_pin.Plant(
    arm,
    friction=asmc_pin.Friction(coulomb=4.0, viscous=1.0, breakaway=6.0, stribeck_velocity=0.05),
    drive=asmc_pin.Drive(delay=1.0, current_hz=500.0),
    sensor=asmc_pin.Sensor(bits=18, velocity="difference"),
    seed=1,
)
law = asmc_pin.load_experiment("demo").build_controllers()["PPC"]
motion = asmc_pin.load_experiment("demo").build_reference()

for name, plant in (("ideal", ideal), ("real", real)):
    run = asmc_pin.rollout(plant, law, motion, duration=1.0, batch=2)
    print(f"{name} plant: {run}", end="\n\n")
