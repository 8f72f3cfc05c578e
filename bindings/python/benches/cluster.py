"""What Dask costs: a comparison by one process, and by worker processes; and a task that does nothing.

    python benches/cluster.py --plants 2048 --workers 1 2

Each worker computes in one thread. Processor time is that of the workers' tasks alone, so that the share of
the clock that they did not use is what waiting, moving and whoever else is on the machine took.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ["RAYON_NUM_THREADS"] = "1"

import twinrotor as tr
from distributed import Client, LocalCluster
from twinrotor import _native
from twinrotor._gains import rig_text

CONTROLLERS = [("the preset's", None), ("the paper's", "paper")]


def chunk(rig: str, plants: int, first: int, end: int) -> tuple[bytes, float]:
    """A chunk, and the processor time that it took."""
    begun = time.process_time()
    data = _native.compare_chunk(rig, CONTROLLERS, plants, 1, first, end)
    return data, time.process_time() - begun


def nothing(k: int) -> int:
    return k


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", type=int, default=2_048)
    parser.add_argument("--chunk", type=int, default=64)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    arguments = parser.parse_args()
    rig, plants = rig_text("aero2"), arguments.plants
    clock, processor = time.perf_counter(), time.process_time()
    alone = tr.compare("aero2", dict(CONTROLLERS), plants=plants)
    clock, processor = time.perf_counter() - clock, time.process_time() - processor
    print(f"one process: {clock:.2f} s by the clock, {processor:.2f} s of processor time")
    for workers in arguments.workers:
        with (
            LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            client.wait_for_workers(workers)
            client.gather(client.map(nothing, range(100), pure=False))
            begun = time.perf_counter()
            client.gather(client.map(nothing, range(2_000), pure=False))
            empty = (time.perf_counter() - begun) / 2_000
            bounds = [(k, min(k + arguments.chunk, plants)) for k in range(0, plants, arguments.chunk)]
            begun = time.perf_counter()
            futures = [client.submit(chunk, rig, plants, *pair, pure=False) for pair in bounds]
            found = client.gather(futures)
            clock = time.perf_counter() - begun
            used = sum(seconds for _, seconds in found)
            rows = _native.compare_chunks(rig, CONTROLLERS, plants, 1, [data for data, _ in found])
            assert all(
                (costs == alone[name].costs).all() for (costs, _), name in zip(rows, alone, strict=True)
            )
        print(
            f"{workers} workers: {clock:.2f} s by the clock, {used:.2f} s of processor time in {len(bounds)} "
            f"tasks ({used / len(bounds) * 1e3:.0f} ms each, {len(found[0][0]) / 1e3:.0f} kB back); "
            f"a task that does nothing {empty * 1e3:.2f} ms"
        )
