"""Data sets in a store that speaks the protocol of S3, a server of this machine."""

from __future__ import annotations

import gc
import json
import os
import socket
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import numpy as np
import pytest
from typer.testing import CliRunner

import elastomorph as em
from children import started
from elastomorph.cli.app import app
from elastomorph.farm.making.verify import verify_faces
from needs import extra

extra("distributed", "farm")
extra("s3fs", "s3")
boto3 = extra("boto3", "dev")
extra("moto", "dev")

from dask_processes import separate  # noqa: E402

pytestmark = [
    pytest.mark.cluster,
    # Sessions of a client that never reached a store are left to the interpreter.
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]
FACES = 200


@pytest.fixture(autouse=True, scope="module")
def _sessions_end_here() -> Iterator[None]:
    """What clients left open is collected here, not while a test of another file runs."""
    yield
    import s3fs

    s3fs.S3FileSystem.clear_instance_cache()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()


class Store:
    """A server with a bucket, ``faces``, and one user who may do everything there."""

    def __init__(self, process: subprocess.Popen[str], port: int) -> None:
        self.process, self.url = process, f"http://127.0.0.1:{port}"
        self.options = {"key": "anybody", "secret": "anything", "endpoint_url": self.url}

    def client(self, service: str) -> Any:
        return boto3.client(
            service,
            endpoint_url=self.url,
            aws_access_key_id="anybody",
            aws_secret_access_key="anything",
            region_name="us-east-1",
        )


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Store]:
    """A server of its own on the loopback, ended with the test; nobody is known by the machine."""
    for name in [own for own in os.environ if own.startswith(("AWS_", "FSSPEC_"))]:
        monkeypatch.delenv(name)
    for name in ("AWS_CONFIG_FILE", "AWS_SHARED_CREDENTIALS_FILE"):
        monkeypatch.setenv(name, str(tmp_path / "none"))
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    words = ("-m", "moto.server", "-H", "127.0.0.1", "-p", str(port))
    quiet = subprocess.DEVNULL
    with started(*words, stdout=quiet, stderr=quiet) as process:
        found, limit = Store(process, port), time.monotonic() + 60
        while True:
            assert process.poll() is None
            assert time.monotonic() < limit
            with suppress(OSError), socket.create_connection(("127.0.0.1", port)):
                break
            time.sleep(0.1)
        found.client("s3").create_bucket(Bucket="faces")
        yield found


def test_every_executor_makes_in_a_store_what_it_makes_on_a_disk(
    rig: em.Rig, store: Store, tmp_path: Path
) -> None:
    """At the first run; then another one in its place, grown, by workers that have stood since."""
    disk = em.make_faces(rig, tmp_path / "faces.zarr", FACES, vertices="int16", unit=32)
    options: dict[str, Any] = {"vertices": "int16", "unit": 32, "storage_options": store.options}
    with separate() as machines:
        for name, scheduler in {"a": "none", "b": "local", "c": machines.address}.items():
            place = f"s3://faces/{name}.zarr"
            made = em.make_faces(rig, place, FACES, scheduler=scheduler, **options)
            assert (made[:] == disk[:]).all()
            assert (made.weights[:] == disk.weights[:]).all()
            assert len(made.data.manifest.all_finished()) == made.data.manifest.units
        assert verify_faces(place, 2, storage_options=store.options).same
        bucket = store.client("s3")
        for each in bucket.list_objects_v2(Bucket="faces", Prefix="c.zarr/")["Contents"]:
            bucket.delete_object(Bucket="faces", Key=each["Key"])
        for faces in (FACES // 2, FACES):
            em.make_faces(rig, place, faces, seed=1, scheduler=machines.address, **options)
        grown = em.open_faces(place, storage_options=store.options)
        assert (grown.codes[:] == em.FaceSampler(rig, seed=1).codes(0, FACES)).all()
        with pytest.raises(em.FormatError, match="not the data set that it was"):
            made[:]


def test_a_store_that_does_not_answer_is_one_sentence(rig: em.Rig, store: Store) -> None:
    """From every door; what was finished before is gone on with where the store is back."""
    place, known = "s3://faces/faces.zarr", store.options
    nowhere = {**known, "endpoint_url": "http://127.0.0.1:9"}
    unknown = {"endpoint_url": store.url}
    nonsense = [{**known, "nonsense": 1}, {**known, "endpoint_url": "nonsense"}]
    for options in (nowhere, unknown, *nonsense):
        for call in (
            lambda own: em.open_faces(place, storage_options=own),
            lambda own: em.make_faces(rig, place, 9, storage_options=own),
            lambda own: verify_faces(place, storage_options=own),
        ):
            refused(call, options)
    refused(lambda own: em.make_faces(rig, "s3://no-such-bucket/f", 9, storage_options=own), known)

    open_before = em.make_faces(rig, place, 64, unit=32, storage_options=known)

    def kill(state: object) -> None:
        if "64 of" in str(state):
            store.process.kill()
            store.process.wait()

    refused(
        lambda own: em.make_faces(
            rig, place, 10**5, unit=32, storage_options=own, progress=kill, scheduler="none"
        ),
        known,
    )
    refused(lambda own: open_before[:], known)
    refused(lambda own: open_before.rig, known)
    refused(lambda own: em.open_faces(place, storage_options=own), known)


def test_a_store_that_goes_away_from_workers_is_one_sentence(rig: em.Rig, store: Store) -> None:
    def kill(state: object) -> None:
        store.process.kill()

    with separate() as machines:
        refused(
            lambda own: em.make_faces(
                rig,
                "s3://faces/faces.zarr",
                10**5,
                unit=32,
                scheduler=machines.address,
                storage_options=own,
                progress=kill,
            ),
            store.options,
        )


def test_wrong_credentials_are_one_sentence(rig: em.Rig, store: Store) -> None:
    """The server lets anybody in until it is told not to."""
    place = "s3://faces/faces.zarr"
    users = store.client("iam")
    users.create_user(UserName="maker")
    key = users.create_access_key(UserName="maker")["AccessKey"]
    allowed = {"Effect": "Allow", "Action": "*", "Resource": "*"}
    policy = json.dumps({"Version": "2012-10-17", "Statement": [allowed]})
    users.put_user_policy(UserName="maker", PolicyName="all", PolicyDocument=policy)
    plain = {"Content-Type": "text/plain"}
    with urlopen(Request(f"{store.url}/moto-api/reset-auth", b"0", plain)) as answer:
        assert answer.status == 200
    right = {"key": key["AccessKeyId"], "secret": key["SecretAccessKey"], "endpoint_url": store.url}
    made = em.make_faces(rig, place, 9, storage_options=right)
    assert np.isfinite(made[:]).all()
    for wrong in ({**right, "secret": "wrong"}, store.options):
        refused(lambda own: em.open_faces(place, storage_options=own), wrong)
        refused(lambda own: em.make_faces(rig, place, 20, storage_options=own), wrong)


def test_options_and_variables_reach_a_store(
    rig: em.Rig, store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.save(tmp_path / "rig.npz")
    words = [str(tmp_path / "rig.npz"), "--faces", "9", "-o", "s3://faces/faces.zarr"]
    chosen = [f"--storage-option={name}={value}" for name, value in store.options.items()]
    runner = CliRunner()
    for nowhere in ([], ["--storage-option", "endpoint_url=http://127.0.0.1:9", *chosen[:2]]):
        said = subprocess.run(
            [sys.executable, "-m", "elastomorph", "farm", *words, *nowhere],
            capture_output=True,
            text=True,
        )
        assert said.returncode == 1
        assert said.stderr.startswith("error: s3://faces/faces.zarr: ")
        assert said.stderr.count("\n") == 1
    assert runner.invoke(app, ["farm", *words, *chosen]).exit_code == 0
    verified = runner.invoke(app, ["farm", "--verify", *words[3:], *chosen])
    assert verified.exit_code == 0
    assert "bit for bit" in verified.stdout
    assert runner.invoke(app, ["farm", *words, "--storage-option=key"]).exit_code != 0
    refused(lambda own: em.open_faces(words[-1], storage_options=own), {})
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "anybody")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "anything")
    monkeypatch.setenv("AWS_ENDPOINT_URL", store.url)
    assert len(em.open_faces("s3://faces/faces.zarr")) == 9


def refused(call: Any, options: dict[str, Any]) -> None:
    """The call ends with one sentence that names the place."""
    with pytest.raises(em.ElastomorphError, match="s3://") as caught:
        call(options)
    assert "\n" not in str(caught.value)
    assert "damaged" not in str(caught.value)
