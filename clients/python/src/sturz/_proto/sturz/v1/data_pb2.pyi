from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class DataType(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DATA_TYPE_UNSPECIFIED: _ClassVar[DataType]
    DATA_TYPE_F64: _ClassVar[DataType]
    DATA_TYPE_F32: _ClassVar[DataType]
    DATA_TYPE_U64: _ClassVar[DataType]
    DATA_TYPE_U32: _ClassVar[DataType]

class ContactKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CONTACT_KIND_UNSPECIFIED: _ClassVar[ContactKind]
    CONTACT_KIND_SMOOTH: _ClassVar[ContactKind]
    CONTACT_KIND_VERTEX_FACE: _ClassVar[ContactKind]
    CONTACT_KIND_EDGE_EDGE: _ClassVar[ContactKind]
    CONTACT_KIND_MANIFOLD: _ClassVar[ContactKind]
    CONTACT_KIND_OVERLAP: _ClassVar[ContactKind]

class FieldQuantity(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FIELD_QUANTITY_UNSPECIFIED: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_SOLID_FRACTION: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_DENSITY: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_MOMENTUM: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_VELOCITY: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_GRANULAR_TEMPERATURE: _ClassVar[FieldQuantity]
DATA_TYPE_UNSPECIFIED: DataType
DATA_TYPE_F64: DataType
DATA_TYPE_F32: DataType
DATA_TYPE_U64: DataType
DATA_TYPE_U32: DataType
CONTACT_KIND_UNSPECIFIED: ContactKind
CONTACT_KIND_SMOOTH: ContactKind
CONTACT_KIND_VERTEX_FACE: ContactKind
CONTACT_KIND_EDGE_EDGE: ContactKind
CONTACT_KIND_MANIFOLD: ContactKind
CONTACT_KIND_OVERLAP: ContactKind
FIELD_QUANTITY_UNSPECIFIED: FieldQuantity
FIELD_QUANTITY_SOLID_FRACTION: FieldQuantity
FIELD_QUANTITY_DENSITY: FieldQuantity
FIELD_QUANTITY_MOMENTUM: FieldQuantity
FIELD_QUANTITY_VELOCITY: FieldQuantity
FIELD_QUANTITY_GRANULAR_TEMPERATURE: FieldQuantity

class Vec3(_message.Message):
    __slots__ = ("x", "y", "z")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class Quaternion(_message.Message):
    __slots__ = ("w", "x", "y", "z")
    W_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    w: float
    x: float
    y: float
    z: float
    def __init__(self, w: _Optional[float] = ..., x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class Pose(_message.Message):
    __slots__ = ("position_m", "orientation")
    POSITION_M_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    position_m: Vec3
    orientation: Quaternion
    def __init__(self, position_m: _Optional[_Union[Vec3, _Mapping]] = ..., orientation: _Optional[_Union[Quaternion, _Mapping]] = ...) -> None: ...

class Header(_message.Message):
    __slots__ = ("schema_version", "run_id", "seq", "step", "sim_time_s", "wall_time_ns", "topology_epoch")
    SCHEMA_VERSION_FIELD_NUMBER: _ClassVar[int]
    RUN_ID_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    SIM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    WALL_TIME_NS_FIELD_NUMBER: _ClassVar[int]
    TOPOLOGY_EPOCH_FIELD_NUMBER: _ClassVar[int]
    schema_version: int
    run_id: str
    seq: int
    step: int
    sim_time_s: float
    wall_time_ns: int
    topology_epoch: int
    def __init__(self, schema_version: _Optional[int] = ..., run_id: _Optional[str] = ..., seq: _Optional[int] = ..., step: _Optional[int] = ..., sim_time_s: _Optional[float] = ..., wall_time_ns: _Optional[int] = ..., topology_epoch: _Optional[int] = ...) -> None: ...

class Column(_message.Message):
    __slots__ = ("name", "dtype", "components", "data", "unit")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DTYPE_FIELD_NUMBER: _ClassVar[int]
    COMPONENTS_FIELD_NUMBER: _ClassVar[int]
    DATA_FIELD_NUMBER: _ClassVar[int]
    UNIT_FIELD_NUMBER: _ClassVar[int]
    name: str
    dtype: DataType
    components: int
    data: bytes
    unit: str
    def __init__(self, name: _Optional[str] = ..., dtype: _Optional[_Union[DataType, str]] = ..., components: _Optional[int] = ..., data: _Optional[bytes] = ..., unit: _Optional[str] = ...) -> None: ...

class Frame(_message.Message):
    __slots__ = ("header", "n", "columns", "boundaries", "gravity_m_per_s2")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    N_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    BOUNDARIES_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_M_PER_S2_FIELD_NUMBER: _ClassVar[int]
    header: Header
    n: int
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    boundaries: _containers.RepeatedCompositeFieldContainer[BoundaryState]
    gravity_m_per_s2: Vec3
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., n: _Optional[int] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., boundaries: _Optional[_Iterable[_Union[BoundaryState, _Mapping]]] = ..., gravity_m_per_s2: _Optional[_Union[Vec3, _Mapping]] = ...) -> None: ...

class BoundaryState(_message.Message):
    __slots__ = ("name", "point_m", "direction", "angle_rad", "angular_velocity_rad_per_s", "force_n", "torque_n_m", "orientation")
    NAME_FIELD_NUMBER: _ClassVar[int]
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    DIRECTION_FIELD_NUMBER: _ClassVar[int]
    ANGLE_RAD_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_VELOCITY_RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    FORCE_N_FIELD_NUMBER: _ClassVar[int]
    TORQUE_N_M_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    name: str
    point_m: Vec3
    direction: Vec3
    angle_rad: float
    angular_velocity_rad_per_s: float
    force_n: Vec3
    torque_n_m: Vec3
    orientation: Quaternion
    def __init__(self, name: _Optional[str] = ..., point_m: _Optional[_Union[Vec3, _Mapping]] = ..., direction: _Optional[_Union[Vec3, _Mapping]] = ..., angle_rad: _Optional[float] = ..., angular_velocity_rad_per_s: _Optional[float] = ..., force_n: _Optional[_Union[Vec3, _Mapping]] = ..., torque_n_m: _Optional[_Union[Vec3, _Mapping]] = ..., orientation: _Optional[_Union[Quaternion, _Mapping]] = ...) -> None: ...

class ContactFrame(_message.Message):
    __slots__ = ("header", "n", "columns")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    N_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    header: Header
    n: int
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., n: _Optional[int] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ...) -> None: ...

class OutputDefinition(_message.Message):
    __slots__ = ("stream", "columns", "float_type", "every_steps", "every_wall_s", "every_sim_s")
    STREAM_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    FLOAT_TYPE_FIELD_NUMBER: _ClassVar[int]
    EVERY_STEPS_FIELD_NUMBER: _ClassVar[int]
    EVERY_WALL_S_FIELD_NUMBER: _ClassVar[int]
    EVERY_SIM_S_FIELD_NUMBER: _ClassVar[int]
    stream: str
    columns: _containers.RepeatedScalarFieldContainer[str]
    float_type: DataType
    every_steps: int
    every_wall_s: float
    every_sim_s: float
    def __init__(self, stream: _Optional[str] = ..., columns: _Optional[_Iterable[str]] = ..., float_type: _Optional[_Union[DataType, str]] = ..., every_steps: _Optional[int] = ..., every_wall_s: _Optional[float] = ..., every_sim_s: _Optional[float] = ...) -> None: ...

class Grid(_message.Message):
    __slots__ = ("min_m", "max_m", "cells_x", "cells_y", "cells_z")
    MIN_M_FIELD_NUMBER: _ClassVar[int]
    MAX_M_FIELD_NUMBER: _ClassVar[int]
    CELLS_X_FIELD_NUMBER: _ClassVar[int]
    CELLS_Y_FIELD_NUMBER: _ClassVar[int]
    CELLS_Z_FIELD_NUMBER: _ClassVar[int]
    min_m: Vec3
    max_m: Vec3
    cells_x: int
    cells_y: int
    cells_z: int
    def __init__(self, min_m: _Optional[_Union[Vec3, _Mapping]] = ..., max_m: _Optional[_Union[Vec3, _Mapping]] = ..., cells_x: _Optional[int] = ..., cells_y: _Optional[int] = ..., cells_z: _Optional[int] = ...) -> None: ...

class FieldDefinition(_message.Message):
    __slots__ = ("name", "grid", "quantities", "width_m", "cutoff_widths")
    NAME_FIELD_NUMBER: _ClassVar[int]
    GRID_FIELD_NUMBER: _ClassVar[int]
    QUANTITIES_FIELD_NUMBER: _ClassVar[int]
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    CUTOFF_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    name: str
    grid: Grid
    quantities: _containers.RepeatedScalarFieldContainer[FieldQuantity]
    width_m: float
    cutoff_widths: float
    def __init__(self, name: _Optional[str] = ..., grid: _Optional[_Union[Grid, _Mapping]] = ..., quantities: _Optional[_Iterable[_Union[FieldQuantity, str]]] = ..., width_m: _Optional[float] = ..., cutoff_widths: _Optional[float] = ...) -> None: ...

class FieldFrame(_message.Message):
    __slots__ = ("header", "name", "grid", "kernel", "width_m", "cutoff_widths", "columns", "total_mass_kg", "total_momentum_kg_m_per_s")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    GRID_FIELD_NUMBER: _ClassVar[int]
    KERNEL_FIELD_NUMBER: _ClassVar[int]
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    CUTOFF_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    TOTAL_MASS_KG_FIELD_NUMBER: _ClassVar[int]
    TOTAL_MOMENTUM_KG_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    header: Header
    name: str
    grid: Grid
    kernel: str
    width_m: float
    cutoff_widths: float
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    total_mass_kg: float
    total_momentum_kg_m_per_s: Vec3
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., name: _Optional[str] = ..., grid: _Optional[_Union[Grid, _Mapping]] = ..., kernel: _Optional[str] = ..., width_m: _Optional[float] = ..., cutoff_widths: _Optional[float] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., total_mass_kg: _Optional[float] = ..., total_momentum_kg_m_per_s: _Optional[_Union[Vec3, _Mapping]] = ...) -> None: ...
