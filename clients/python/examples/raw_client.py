"""Eclipse-zenoh, protobuf and the .proto files are enough: `python raw_client.py ENDPOINT INSTANCE PROTO_FOLDER`."""

import itertools
import struct
import sys
import tempfile

import zenoh
from grpc_tools import protoc

endpoint, instance, proto = sys.argv[1:]
folder = tempfile.mkdtemp()
files = [f"sturz/v1/{name}.proto" for name in ("data", "command", "status")]
assert protoc.main(["protoc", f"-I{proto}", f"--python_out={folder}", *files]) == 0
sys.path.insert(0, folder)
from sturz.v1 import command_pb2, data_pb2, status_pb2  # noqa: E402

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", f'["{endpoint}"]')
config.insert_json5("scouting/multicast/enabled", "false")
session = zenoh.open(config)
request_ids = itertools.count(1)


def ask(key, payload=None):
    for reply in session.get(f"sturz/v1/{instance}/{key}", payload=payload, timeout=60.0):
        if reply.ok is None:
            raise SystemExit(text_of(command_pb2.Error.FromString(reply.err.payload.to_bytes())))
        return reply.ok.payload.to_bytes()
    raise SystemExit(f"{key}: no answer")


def text_of(error):
    return f"{command_pb2.ErrorCode.Name(error.code)} {error.path}: {error.message}"


def command(verb, request):
    request.header.client_id, request.header.request_id = "raw", str(next(request_ids))
    return command_pb2.Outcome.FromString(ask(f"cmd/{verb}", request.SerializeToString()))


info = status_pb2.Info.FromString(ask("info"))
print(f"schema {info.schema_version}, {info.scene}: step {info.step}, {info.sim_time_s} s")
xyz = data_pb2.Column(
    name="positions_m", dtype="DATA_TYPE_F64", components=3, data=struct.pack("<6d", 0, 0, 1, 0, 1, 1)
)
poses = command_pb2.PosesPlacement(positions_m=xyz)
insert = command_pb2.InsertRequest(shape=info.shapes[0], material=info.materials[0], poses=poses)
print(f"inserted from id {command('insert', insert).inserted.first_id}")
window = command_pb2.AdvanceRequest(from_time_s=info.sim_time_s, window_s=0.01)
window.outputs.columns.append("velocities")
done = command("advance", window).advanced
print(f"at {done.time_reached_s} s after {done.steps_done} steps: {[column.name for column in done.frame.columns]}")
frame = data_pb2.Frame.FromString(ask("state/latest?columns=positions"))
positions = next(column for column in frame.columns if column.name == "positions")
for row in struct.iter_unpack("<3d", positions.data):
    print("position", row)
print("refused:", text_of(command("remove", command_pb2.RemoveRequest(ids=[99])).error))
session.close()
