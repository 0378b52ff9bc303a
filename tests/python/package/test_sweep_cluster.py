"""Sweeps on a cluster of Dask, a worker or the scheduler of which is killed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("distributed")

CLUSTER = """
import os, signal, sys, time
import numpy as np
import gearbow as gb
from distributed import Client, LocalCluster
from test_dataset import made
from test_sweep import GRID, force, pair, same

def main():
    folder = sys.argv[1]
    cluster = LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
        local_directory=folder,
    )
    with cluster, Client(cluster) as client:
        workers = [entry["pid"] for entry in client.run(lambda: {"pid": os.getpid()}).values()]
        assert len(set(workers)) == 2
        killed = []

        def report(fraction):
            if fraction > 0.2 and not killed:
                killed.append(workers[0])
                os.kill(workers[0], signal.SIGKILL)

        sweep = gb.sweep(
            pair, GRID, slow, client.get_executor(), f"{folder}/map.sweep", report
        )
        assert killed and not sweep.failed and sweep.computed == len(sweep) == 6, sweep
        made(f"{folder}/pair.nc", executor=client.get_executor())
    content = open(f"{folder}/pair.nc", "rb").read()
    made(f"{folder}/pair.nc")
    assert open(f"{folder}/pair.nc", "rb").read() == content
    same(sweep, gb.sweep(pair, GRID, slow))
    same(sweep, gb.Sweep.load(f"{folder}/map.sweep"))
    print("done")

def slow(system, **parameters):
    time.sleep(0.2)  # so that the killed worker has points to compute
    return force(system, **parameters)

if __name__ == "__main__":
    main()
"""


RESTART = """
import socket, subprocess, sys, time
import gearbow as gb
from distributed import Client
from test_sweep import GRID, force, pair, same

def started(address):
    port = address.rpartition(":")[2]
    tool = [sys.executable, "-m", "distributed.cli.dask_"]
    scheduler = ["scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard"]
    worker = ["worker", address, "--nthreads", "1", "--no-dashboard", "--death-timeout", "60"]
    return [
        subprocess.Popen([*tool[:2], tool[2] + name, *given], stderr=subprocess.DEVNULL)
        for name, *given in (scheduler, worker)
    ]

def main():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    processes, store = started(address), f"{sys.argv[1]}/map.sweep"
    try:
        client = Client(address, timeout=60)

        def restart(fraction):
            if fraction > 0.2 and len(processes) == 2:
                processes[0].kill()
                processes[0].wait()
                processes.extend(started(address))

        try:
            gb.sweep(pair, GRID, slow, client.get_executor(), store, restart)
        except gb.GearbowError as error:
            assert str(error).startswith("executor: its workers have ended"), error
            part = error.sweep
        assert 2 <= part.computed < 6, part
        client.close(timeout=10)
        reports = []
        with Client(address, timeout=60) as client:
            sweep = gb.sweep(pair, GRID, slow, client.get_executor(), store, reports.append)
        assert reports[0] == part.computed / 6, reports
        same(sweep, gb.sweep(pair, GRID, force))
    finally:
        for process in processes:
            process.kill()
            process.wait()
    print("done")

def slow(system, **parameters):
    time.sleep(0.2)  # so that points are left when the scheduler ends
    return force(system, **parameters)

if __name__ == "__main__":
    main()
"""


@pytest.mark.skipif(os.name != "posix", reason="kills a process")
@pytest.mark.parametrize("program", [CLUSTER, RESTART], ids=["worker", "scheduler"])
def test_a_killed_process_of_a_cluster_does_not_lose_points(tmp_path, program):
    script = tmp_path / "cluster.py"  # the workers import the functions of the main module
    script.write_text(program, encoding="utf-8")
    here = str(Path(__file__).parents[1])
    path = os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")]))
    ended = subprocess.run(
        [sys.executable, script, tmp_path],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (0, "done\n"), ended.stderr
