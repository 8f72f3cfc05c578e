# %% [markdown]
# # From a log to gains
#
# `examples/identify_and_tune.py`: a rig that the program knows by its log alone is identified, gains are
# tuned for what was found, and both sets of gains fly the rig.

# %%
import sys

sys.path.insert(0, "..")  # where the example is
import identify_and_tune as example
import matplotlib.pyplot as plt
import numpy as np
import twinrotor as tr

truth = tr.draw(example.PRESET, 1, seed=5)[0]
log = tr.simulate(example.PRESET, None, example.EXCITE, fidelity="rig", true_rig=truth).log
print("what a logger on the rig writes:", ", ".join(log))

# %%
found, table = example.run(seed=5, plants=16, iterations=12)
for constant in found.constants:
    interval = "" if constant.ci95 is None else f"{constant.ci95[0]:.3e} to {constant.ci95[1]:.3e}"
    print(f"{constant.name:32} {constant.value:11.3e} {constant.unit:10} {interval}")
for name, (total, pitch, yaw) in table.items():
    print(f"{name:15} J {total:7.3f}   errors {pitch:.2f} and {yaw:.2f} degrees")

# %% [markdown]
# The rig in the paper's second scenario, flown by a controller that believes in the preset, and by one that
# believes in what was found.

# %%
figure, axes = plt.subplots(1, 2, figsize=(8.0, 3.0), sharex=True)
for name, preset in {"believes in the preset": example.PRESET, "in what was found": found.rig}.items():
    gains = tr.Gains.of_preset(example.PRESET)
    flight = tr.simulate(preset, gains, "2", fidelity="rig", duration=20.0, true_rig=truth)
    for axis, (part, reference) in enumerate(zip(axes, ["theta_ref", "psi_ref"], strict=True)):
        part.plot(flight["t"], np.degrees(flight.angle[:, axis] - flight[reference]), label=name)
for part, name in zip(axes, ["pitch", "yaw"], strict=True):
    part.set(xlabel="t [s]", ylabel=f"error in {name} [deg]")
axes[0].legend()
figure.tight_layout()
