# %% [markdown]
# # A small policy, learned on many plants at once
#
# Sixteen weights from observation to volts, by the cross-entropy method: `examples/learn_policy.py`. Every
# generation flies 64 candidates on the same four drawn plants, all together in a `twinrotor.Batch`.

# %%
import sys

sys.path.insert(0, "..")  # where the example is
import learn_policy as example
import matplotlib.pyplot as plt
import numpy as np
import twinrotor as tr

course = []
weights = example.learn(30, told=lambda _, means: course.append((means.min(), means.mean(), means.max())))
figure, axes = plt.subplots(figsize=(6.0, 3.0))
for column, name in enumerate(["worst", "mean", "best"]):
    axes.plot(-np.array(course)[:, column], label=name)
axes.set(xlabel="generation", ylabel="minus the return", yscale="log")
axes.legend()
axes.grid(alpha=0.3)

# %% [markdown]
# Ranked on a hundred plants that no learning has seen, from the same seeds for all. A return counts the
# error of four seconds; it does not say how long a policy goes on holding, nor what keeps the rig whole.

# %%
ranked = example.rank(weights)
for name, found in ranked.items():
    print(f"{name:17} mean {found.mean():7.2f}   worst {found.min():8.2f}")

# %% [markdown]
# One flight of each, with the same plant and goal.

# %%
flights = {"learned": ("volts", example.linear(weights)), "the board's loop": ("setpoint", None)}
figure, axes = plt.subplots(1, 2, figsize=(8.0, 3.0), sharex=True)
for name, (action, act) in flights.items():
    batch = tr.Batch("aero2", 1, action=action, seconds=8.0)
    seen = batch.begin(10**6 + 3)
    goal = batch.goals()[0]
    rows = []
    for _ in range(399):
        given = goal[None] / np.radians([25.0, 90.0]) if act is None else act(seen)
        seen = batch.fly(given).observations
        rows.append(np.degrees(seen[0, :2]))
    for axis, part in enumerate(axes):
        part.plot(0.02 * np.arange(1, 400), np.array(rows)[:, axis], label=name)
for part, name, wanted in zip(axes, ["pitch", "yaw"], np.degrees(goal), strict=True):
    part.axhline(wanted, color="k", linewidth=0.7)
    part.set(xlabel="t [s]", ylabel=f"{name} [deg]")
axes[0].legend()
figure.tight_layout()
