"""Steer a Sturz particle simulation from Python, and read its state and fields as numpy arrays.

>>> import sturz
>>> with sturz.launch("drum-crosses") as simulation:  # doctest: +SKIP
...     simulation.set_gravity(gravity_m_per_s2=(0.0, 0.0, -9.81))
...     simulation.advance(window_s=0.1)
...     print(simulation.state().positions_m.shape)

Units are SI and in the names; angles are in radians. Pictures are in `sturz.plot` (`pip install sturz[plots]`), the
same for asyncio in `sturz.aio`.
"""

from .contacts import NO_BOUNDARY, NO_PARTICLE, ContactKind, Contacts
from .errors import (
    AccessDenied,
    CommandError,
    DaemonDenied,
    DaemonDied,
    DaemonGone,
    DaemonHung,
    DaemonUnreachable,
    ErrorCode,
    LaunchFailed,
    NoAnswer,
    NotConnected,
    ProtocolError,
    SturzError,
    Timeout,
)
from .field import Field, FieldAverage, FieldDefinition, FieldMean, Grid, GridCylinder
from .fluid import Exchange, Fluid, FluidFields, PointMesh, StructuredMesh
from .loads import Loads
from .output import Output
from .participant import CouplingError, Participant
from .simulation import Advanced, Box, Cylinder, Simulation, Stepped, connect, launch
from .sizes import LognormalScale, NormalScale, ScaleTable
from .state import BoundaryState, ColumnMissing, Header, Shape, State
from .status import (
    Boundary,
    Checkpoint,
    CommandOutcome,
    Domain,
    EnergyBalance,
    Event,
    EventKind,
    Features,
    GuardWarning,
    Info,
    LeaseChange,
    Limits,
    Report,
    RunState,
    Severity,
    WarningKind,
)
from .stream import Stream
from .target import Tls

__version__ = "0.1.0"

__all__ = [
    "NO_BOUNDARY",
    "NO_PARTICLE",
    "AccessDenied",
    "Advanced",
    "Boundary",
    "BoundaryState",
    "Box",
    "Checkpoint",
    "ColumnMissing",
    "CommandError",
    "CommandOutcome",
    "ContactKind",
    "Contacts",
    "CouplingError",
    "Cylinder",
    "DaemonDenied",
    "DaemonDied",
    "DaemonGone",
    "DaemonHung",
    "DaemonUnreachable",
    "Domain",
    "EnergyBalance",
    "ErrorCode",
    "Event",
    "EventKind",
    "Exchange",
    "Features",
    "Field",
    "FieldAverage",
    "FieldDefinition",
    "FieldMean",
    "Fluid",
    "FluidFields",
    "Grid",
    "GridCylinder",
    "GuardWarning",
    "Header",
    "Info",
    "LaunchFailed",
    "LeaseChange",
    "Limits",
    "Loads",
    "LognormalScale",
    "NoAnswer",
    "NormalScale",
    "NotConnected",
    "Output",
    "Participant",
    "PointMesh",
    "ProtocolError",
    "Report",
    "RunState",
    "ScaleTable",
    "Severity",
    "Shape",
    "Simulation",
    "State",
    "Stepped",
    "Stream",
    "StructuredMesh",
    "SturzError",
    "Timeout",
    "Tls",
    "WarningKind",
    "connect",
    "launch",
]
