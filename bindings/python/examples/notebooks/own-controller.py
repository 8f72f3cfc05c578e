# %% [markdown]
# # A controller of one's own, beside the board's
#
# `examples/own_controller.py` has an LQR with filtered rates, written in NumPy, and the loop that the
# firmware runs. Both fly the same drawn Aero 2 plants with encoders, rotor lag and PWM steps, and a volt of
# disturbance on each motor.

# %%
import sys

sys.path.insert(0, "..")  # where the example is
import matplotlib.pyplot as plt
import numpy as np
import own_controller as example
import twinrotor as tr

linear = tr.linearize(example.PRESET)
print("poles of the plant, level [1/s]:", np.round(np.sort_complex(np.linalg.eigvals(linear.a)), 2))

# %% [markdown]
# The error that is left in the last of twelve seconds, plant by plant. Feedback of the state alone leaves
# what the disturbance does; the board's loop observes the disturbance and takes it out.

# %%
rigs = tr.draw(example.PRESET, 6, seed=1_000_001)
laws = {"state feedback": example.state_feedback, "the board's": example.boards}
errors = {name: [example.fly(rig, law()) for rig in rigs] for name, law in laws.items()}
figure, axes = plt.subplots(figsize=(6.0, 3.0))
for name, found in errors.items():
    kept = [error for error in found if error is not None]
    axes.semilogy(range(1, len(kept) + 1), sorted(kept), "o-", label=name)
    print(f"{name:15} median {np.median(kept):.3f} degrees, {len(found) - len(kept)} lost")
axes.set(xlabel="plant, by its error", ylabel="error in the last second [deg RMS]")
axes.legend()
axes.grid(alpha=0.3)
