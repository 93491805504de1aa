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
    FIELD_QUANTITY_SOLID_FRACTION_OF_SHAPES: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_NUMBER_DENSITY: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_ANGULAR_VELOCITY: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_VELOCITY_GRADIENT: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_SHEAR_RATE: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_CONTACT_STRESS: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_CONTACT_STRESS_PAIRS: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_CONTACT_STRESS_BOUNDARIES: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_KINETIC_STRESS: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_KINETIC_STRESS_ABOUT_PARTICLES: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_KINETIC_STRESS_OF_GRADIENT: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_KINETIC_STRESS_SCALE_FREE: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_KINETIC_STRESS_OF_ROTATION: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_STRESS: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_PRESSURE: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_SECOND_MOMENT: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_ORIENTATION: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_COORDINATION: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_INERTIAL_NUMBER: _ClassVar[FieldQuantity]
    FIELD_QUANTITY_WALL_FORCE_DENSITY: _ClassVar[FieldQuantity]

class FieldKernel(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FIELD_KERNEL_UNSPECIFIED: _ClassVar[FieldKernel]
    FIELD_KERNEL_GAUSSIAN: _ClassVar[FieldKernel]
    FIELD_KERNEL_LUCY: _ClassVar[FieldKernel]
    FIELD_KERNEL_HEAVISIDE: _ClassVar[FieldKernel]

class BodyAxis(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    BODY_AXIS_UNSPECIFIED: _ClassVar[BodyAxis]
    BODY_AXIS_LONGEST: _ClassVar[BodyAxis]
    BODY_AXIS_SHORTEST: _ClassVar[BodyAxis]
    BODY_AXIS_X: _ClassVar[BodyAxis]
    BODY_AXIS_Y: _ClassVar[BodyAxis]
    BODY_AXIS_Z: _ClassVar[BodyAxis]

class AverageWindow(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    AVERAGE_WINDOW_UNSPECIFIED: _ClassVar[AverageWindow]
    AVERAGE_WINDOW_GROWING: _ClassVar[AverageWindow]
    AVERAGE_WINDOW_SLIDING: _ClassVar[AverageWindow]
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
FIELD_QUANTITY_SOLID_FRACTION_OF_SHAPES: FieldQuantity
FIELD_QUANTITY_NUMBER_DENSITY: FieldQuantity
FIELD_QUANTITY_ANGULAR_VELOCITY: FieldQuantity
FIELD_QUANTITY_VELOCITY_GRADIENT: FieldQuantity
FIELD_QUANTITY_SHEAR_RATE: FieldQuantity
FIELD_QUANTITY_CONTACT_STRESS: FieldQuantity
FIELD_QUANTITY_CONTACT_STRESS_PAIRS: FieldQuantity
FIELD_QUANTITY_CONTACT_STRESS_BOUNDARIES: FieldQuantity
FIELD_QUANTITY_KINETIC_STRESS: FieldQuantity
FIELD_QUANTITY_KINETIC_STRESS_ABOUT_PARTICLES: FieldQuantity
FIELD_QUANTITY_KINETIC_STRESS_OF_GRADIENT: FieldQuantity
FIELD_QUANTITY_KINETIC_STRESS_SCALE_FREE: FieldQuantity
FIELD_QUANTITY_KINETIC_STRESS_OF_ROTATION: FieldQuantity
FIELD_QUANTITY_STRESS: FieldQuantity
FIELD_QUANTITY_PRESSURE: FieldQuantity
FIELD_QUANTITY_SECOND_MOMENT: FieldQuantity
FIELD_QUANTITY_ORIENTATION: FieldQuantity
FIELD_QUANTITY_COORDINATION: FieldQuantity
FIELD_QUANTITY_INERTIAL_NUMBER: FieldQuantity
FIELD_QUANTITY_WALL_FORCE_DENSITY: FieldQuantity
FIELD_KERNEL_UNSPECIFIED: FieldKernel
FIELD_KERNEL_GAUSSIAN: FieldKernel
FIELD_KERNEL_LUCY: FieldKernel
FIELD_KERNEL_HEAVISIDE: FieldKernel
BODY_AXIS_UNSPECIFIED: BodyAxis
BODY_AXIS_LONGEST: BodyAxis
BODY_AXIS_SHORTEST: BodyAxis
BODY_AXIS_X: BodyAxis
BODY_AXIS_Y: BodyAxis
BODY_AXIS_Z: BodyAxis
AVERAGE_WINDOW_UNSPECIFIED: AverageWindow
AVERAGE_WINDOW_GROWING: AverageWindow
AVERAGE_WINDOW_SLIDING: AverageWindow

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

class GridCylinder(_message.Message):
    __slots__ = ("point_m", "axis", "zero")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    ZERO_FIELD_NUMBER: _ClassVar[int]
    point_m: Vec3
    axis: Vec3
    zero: Vec3
    def __init__(self, point_m: _Optional[_Union[Vec3, _Mapping]] = ..., axis: _Optional[_Union[Vec3, _Mapping]] = ..., zero: _Optional[_Union[Vec3, _Mapping]] = ...) -> None: ...

class Grid(_message.Message):
    __slots__ = ("min_m", "max_m", "cells_x", "cells_y", "cells_z", "cylinder")
    MIN_M_FIELD_NUMBER: _ClassVar[int]
    MAX_M_FIELD_NUMBER: _ClassVar[int]
    CELLS_X_FIELD_NUMBER: _ClassVar[int]
    CELLS_Y_FIELD_NUMBER: _ClassVar[int]
    CELLS_Z_FIELD_NUMBER: _ClassVar[int]
    CYLINDER_FIELD_NUMBER: _ClassVar[int]
    min_m: Vec3
    max_m: Vec3
    cells_x: int
    cells_y: int
    cells_z: int
    cylinder: GridCylinder
    def __init__(self, min_m: _Optional[_Union[Vec3, _Mapping]] = ..., max_m: _Optional[_Union[Vec3, _Mapping]] = ..., cells_x: _Optional[int] = ..., cells_y: _Optional[int] = ..., cells_z: _Optional[int] = ..., cylinder: _Optional[_Union[GridCylinder, _Mapping]] = ...) -> None: ...

class GridMotion(_message.Message):
    __slots__ = ("translation_m_per_s", "boundary")
    TRANSLATION_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    BOUNDARY_FIELD_NUMBER: _ClassVar[int]
    translation_m_per_s: Vec3
    boundary: str
    def __init__(self, translation_m_per_s: _Optional[_Union[Vec3, _Mapping]] = ..., boundary: _Optional[str] = ...) -> None: ...

class FieldAverage(_message.Message):
    __slots__ = ("every_steps", "samples_per_block", "blocks", "window", "from_time_s")
    EVERY_STEPS_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_PER_BLOCK_FIELD_NUMBER: _ClassVar[int]
    BLOCKS_FIELD_NUMBER: _ClassVar[int]
    WINDOW_FIELD_NUMBER: _ClassVar[int]
    FROM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    every_steps: int
    samples_per_block: int
    blocks: int
    window: AverageWindow
    from_time_s: float
    def __init__(self, every_steps: _Optional[int] = ..., samples_per_block: _Optional[int] = ..., blocks: _Optional[int] = ..., window: _Optional[_Union[AverageWindow, str]] = ..., from_time_s: _Optional[float] = ...) -> None: ...

class FieldDefinition(_message.Message):
    __slots__ = ("name", "grid", "quantities", "width_m", "cutoff_widths", "kernel", "more_widths_m", "wall_correction", "body_axis", "average", "motion")
    NAME_FIELD_NUMBER: _ClassVar[int]
    GRID_FIELD_NUMBER: _ClassVar[int]
    QUANTITIES_FIELD_NUMBER: _ClassVar[int]
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    CUTOFF_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    KERNEL_FIELD_NUMBER: _ClassVar[int]
    MORE_WIDTHS_M_FIELD_NUMBER: _ClassVar[int]
    WALL_CORRECTION_FIELD_NUMBER: _ClassVar[int]
    BODY_AXIS_FIELD_NUMBER: _ClassVar[int]
    AVERAGE_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    name: str
    grid: Grid
    quantities: _containers.RepeatedScalarFieldContainer[FieldQuantity]
    width_m: float
    cutoff_widths: float
    kernel: FieldKernel
    more_widths_m: _containers.RepeatedScalarFieldContainer[float]
    wall_correction: bool
    body_axis: BodyAxis
    average: FieldAverage
    motion: GridMotion
    def __init__(self, name: _Optional[str] = ..., grid: _Optional[_Union[Grid, _Mapping]] = ..., quantities: _Optional[_Iterable[_Union[FieldQuantity, str]]] = ..., width_m: _Optional[float] = ..., cutoff_widths: _Optional[float] = ..., kernel: _Optional[_Union[FieldKernel, str]] = ..., more_widths_m: _Optional[_Iterable[float]] = ..., wall_correction: bool = ..., body_axis: _Optional[_Union[BodyAxis, str]] = ..., average: _Optional[_Union[FieldAverage, _Mapping]] = ..., motion: _Optional[_Union[GridMotion, _Mapping]] = ...) -> None: ...

class FieldWidth(_message.Message):
    __slots__ = ("width_m", "columns", "standard_errors")
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    STANDARD_ERRORS_FIELD_NUMBER: _ClassVar[int]
    width_m: float
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    standard_errors: _containers.RepeatedCompositeFieldContainer[Column]
    def __init__(self, width_m: _Optional[float] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., standard_errors: _Optional[_Iterable[_Union[Column, _Mapping]]] = ...) -> None: ...

class FieldFrame(_message.Message):
    __slots__ = ("header", "name", "grid", "kernel", "width_m", "cutoff_widths", "columns", "total_mass_kg", "total_momentum_kg_m_per_s", "standard_errors", "more_widths", "samples", "blocks", "from_time_s", "grid_origin_m", "grid_orientation")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    GRID_FIELD_NUMBER: _ClassVar[int]
    KERNEL_FIELD_NUMBER: _ClassVar[int]
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    CUTOFF_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    TOTAL_MASS_KG_FIELD_NUMBER: _ClassVar[int]
    TOTAL_MOMENTUM_KG_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    STANDARD_ERRORS_FIELD_NUMBER: _ClassVar[int]
    MORE_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_FIELD_NUMBER: _ClassVar[int]
    BLOCKS_FIELD_NUMBER: _ClassVar[int]
    FROM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    GRID_ORIGIN_M_FIELD_NUMBER: _ClassVar[int]
    GRID_ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    header: Header
    name: str
    grid: Grid
    kernel: str
    width_m: float
    cutoff_widths: float
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    total_mass_kg: float
    total_momentum_kg_m_per_s: Vec3
    standard_errors: _containers.RepeatedCompositeFieldContainer[Column]
    more_widths: _containers.RepeatedCompositeFieldContainer[FieldWidth]
    samples: int
    blocks: int
    from_time_s: float
    grid_origin_m: Vec3
    grid_orientation: Quaternion
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., name: _Optional[str] = ..., grid: _Optional[_Union[Grid, _Mapping]] = ..., kernel: _Optional[str] = ..., width_m: _Optional[float] = ..., cutoff_widths: _Optional[float] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., total_mass_kg: _Optional[float] = ..., total_momentum_kg_m_per_s: _Optional[_Union[Vec3, _Mapping]] = ..., standard_errors: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., more_widths: _Optional[_Iterable[_Union[FieldWidth, _Mapping]]] = ..., samples: _Optional[int] = ..., blocks: _Optional[int] = ..., from_time_s: _Optional[float] = ..., grid_origin_m: _Optional[_Union[Vec3, _Mapping]] = ..., grid_orientation: _Optional[_Union[Quaternion, _Mapping]] = ...) -> None: ...

class ExchangeFrame(_message.Message):
    __slots__ = ("header", "from_time_s", "columns", "solid_volume_m3", "immersed_volume_m3", "outside", "impulse_on_fluid_n_s", "pressure_impulse_n_s", "buoyancy_impulse_n_s", "momentum_kg_m_per_s", "refreshes")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    FROM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    SOLID_VOLUME_M3_FIELD_NUMBER: _ClassVar[int]
    IMMERSED_VOLUME_M3_FIELD_NUMBER: _ClassVar[int]
    OUTSIDE_FIELD_NUMBER: _ClassVar[int]
    IMPULSE_ON_FLUID_N_S_FIELD_NUMBER: _ClassVar[int]
    PRESSURE_IMPULSE_N_S_FIELD_NUMBER: _ClassVar[int]
    BUOYANCY_IMPULSE_N_S_FIELD_NUMBER: _ClassVar[int]
    MOMENTUM_KG_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    REFRESHES_FIELD_NUMBER: _ClassVar[int]
    header: Header
    from_time_s: float
    columns: _containers.RepeatedCompositeFieldContainer[Column]
    solid_volume_m3: float
    immersed_volume_m3: float
    outside: int
    impulse_on_fluid_n_s: Vec3
    pressure_impulse_n_s: Vec3
    buoyancy_impulse_n_s: Vec3
    momentum_kg_m_per_s: Vec3
    refreshes: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., from_time_s: _Optional[float] = ..., columns: _Optional[_Iterable[_Union[Column, _Mapping]]] = ..., solid_volume_m3: _Optional[float] = ..., immersed_volume_m3: _Optional[float] = ..., outside: _Optional[int] = ..., impulse_on_fluid_n_s: _Optional[_Union[Vec3, _Mapping]] = ..., pressure_impulse_n_s: _Optional[_Union[Vec3, _Mapping]] = ..., buoyancy_impulse_n_s: _Optional[_Union[Vec3, _Mapping]] = ..., momentum_kg_m_per_s: _Optional[_Union[Vec3, _Mapping]] = ..., refreshes: _Optional[int] = ...) -> None: ...
