from . import data_pb2 as _data_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class DragLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DRAG_LAW_UNSPECIFIED: _ClassVar[DragLaw]
    DRAG_LAW_NONE: _ClassVar[DragLaw]
    DRAG_LAW_STOKES: _ClassVar[DragLaw]
    DRAG_LAW_SCHILLER_NAUMANN: _ClassVar[DragLaw]
    DRAG_LAW_HAIDER_LEVENSPIEL: _ClassVar[DragLaw]
    DRAG_LAW_GANSER: _ClassVar[DragLaw]
    DRAG_LAW_HOLZER_SOMMERFELD: _ClassVar[DragLaw]

class VoidageLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    VOIDAGE_LAW_UNSPECIFIED: _ClassVar[VoidageLaw]
    VOIDAGE_LAW_NONE: _ClassVar[VoidageLaw]
    VOIDAGE_LAW_DI_FELICE: _ClassVar[VoidageLaw]
    VOIDAGE_LAW_GIDASPOW: _ClassVar[VoidageLaw]
    VOIDAGE_LAW_TENNETI: _ClassVar[VoidageLaw]
    VOIDAGE_LAW_BEETSTRA: _ClassVar[VoidageLaw]

class LiftLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    LIFT_LAW_UNSPECIFIED: _ClassVar[LiftLaw]
    LIFT_LAW_SAFFMAN_MEI: _ClassVar[LiftLaw]
    LIFT_LAW_CROSS_FLOW: _ClassVar[LiftLaw]

class PitchingLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PITCHING_LAW_UNSPECIFIED: _ClassVar[PitchingLaw]
    PITCHING_LAW_ROSENDAHL: _ClassVar[PitchingLaw]

class RotationalDragLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ROTATIONAL_DRAG_LAW_UNSPECIFIED: _ClassVar[RotationalDragLaw]
    ROTATIONAL_DRAG_LAW_STOKES: _ClassVar[RotationalDragLaw]
    ROTATIONAL_DRAG_LAW_DENNIS: _ClassVar[RotationalDragLaw]

class MeshSide(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    MESH_SIDE_UNSPECIFIED: _ClassVar[MeshSide]
    MESH_SIDE_CLOSED: _ClassVar[MeshSide]
    MESH_SIDE_OPEN: _ClassVar[MeshSide]
    MESH_SIDE_PERIODIC: _ClassVar[MeshSide]

class StopReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    STOP_REASON_UNSPECIFIED: _ClassVar[StopReason]
    STOP_REASON_COMPLETE: _ClassVar[StopReason]
    STOP_REASON_PAUSED: _ClassVar[StopReason]
    STOP_REASON_STOPPED: _ClassVar[StopReason]
    STOP_REASON_LEASE_LOST: _ClassVar[StopReason]

class ErrorCode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ERROR_CODE_UNSPECIFIED: _ClassVar[ErrorCode]
    ERROR_CODE_UNDECODABLE: _ClassVar[ErrorCode]
    ERROR_CODE_INVALID_INPUT: _ClassVar[ErrorCode]
    ERROR_CODE_TOO_LARGE: _ClassVar[ErrorCode]
    ERROR_CODE_BUSY: _ClassVar[ErrorCode]
    ERROR_CODE_NOT_PAUSED: _ClassVar[ErrorCode]
    ERROR_CODE_WINDOW_IN_FLIGHT: _ClassVar[ErrorCode]
    ERROR_CODE_WRONG_TIME: _ClassVar[ErrorCode]
    ERROR_CODE_REQUEST_ID_REUSED: _ClassVar[ErrorCode]
    ERROR_CODE_NOT_FOUND: _ClassVar[ErrorCode]
    ERROR_CODE_RUN_FAILED: _ClassVar[ErrorCode]
    ERROR_CODE_STOPPING: _ClassVar[ErrorCode]
    ERROR_CODE_INTERNAL: _ClassVar[ErrorCode]
    ERROR_CODE_UNUSABLE_CHECKPOINT: _ClassVar[ErrorCode]
    ERROR_CODE_DISK: _ClassVar[ErrorCode]
    ERROR_CODE_LEASE: _ClassVar[ErrorCode]
    ERROR_CODE_RECORDING: _ClassVar[ErrorCode]
DRAG_LAW_UNSPECIFIED: DragLaw
DRAG_LAW_NONE: DragLaw
DRAG_LAW_STOKES: DragLaw
DRAG_LAW_SCHILLER_NAUMANN: DragLaw
DRAG_LAW_HAIDER_LEVENSPIEL: DragLaw
DRAG_LAW_GANSER: DragLaw
DRAG_LAW_HOLZER_SOMMERFELD: DragLaw
VOIDAGE_LAW_UNSPECIFIED: VoidageLaw
VOIDAGE_LAW_NONE: VoidageLaw
VOIDAGE_LAW_DI_FELICE: VoidageLaw
VOIDAGE_LAW_GIDASPOW: VoidageLaw
VOIDAGE_LAW_TENNETI: VoidageLaw
VOIDAGE_LAW_BEETSTRA: VoidageLaw
LIFT_LAW_UNSPECIFIED: LiftLaw
LIFT_LAW_SAFFMAN_MEI: LiftLaw
LIFT_LAW_CROSS_FLOW: LiftLaw
PITCHING_LAW_UNSPECIFIED: PitchingLaw
PITCHING_LAW_ROSENDAHL: PitchingLaw
ROTATIONAL_DRAG_LAW_UNSPECIFIED: RotationalDragLaw
ROTATIONAL_DRAG_LAW_STOKES: RotationalDragLaw
ROTATIONAL_DRAG_LAW_DENNIS: RotationalDragLaw
MESH_SIDE_UNSPECIFIED: MeshSide
MESH_SIDE_CLOSED: MeshSide
MESH_SIDE_OPEN: MeshSide
MESH_SIDE_PERIODIC: MeshSide
STOP_REASON_UNSPECIFIED: StopReason
STOP_REASON_COMPLETE: StopReason
STOP_REASON_PAUSED: StopReason
STOP_REASON_STOPPED: StopReason
STOP_REASON_LEASE_LOST: StopReason
ERROR_CODE_UNSPECIFIED: ErrorCode
ERROR_CODE_UNDECODABLE: ErrorCode
ERROR_CODE_INVALID_INPUT: ErrorCode
ERROR_CODE_TOO_LARGE: ErrorCode
ERROR_CODE_BUSY: ErrorCode
ERROR_CODE_NOT_PAUSED: ErrorCode
ERROR_CODE_WINDOW_IN_FLIGHT: ErrorCode
ERROR_CODE_WRONG_TIME: ErrorCode
ERROR_CODE_REQUEST_ID_REUSED: ErrorCode
ERROR_CODE_NOT_FOUND: ErrorCode
ERROR_CODE_RUN_FAILED: ErrorCode
ERROR_CODE_STOPPING: ErrorCode
ERROR_CODE_INTERNAL: ErrorCode
ERROR_CODE_UNUSABLE_CHECKPOINT: ErrorCode
ERROR_CODE_DISK: ErrorCode
ERROR_CODE_LEASE: ErrorCode
ERROR_CODE_RECORDING: ErrorCode

class CommandHeader(_message.Message):
    __slots__ = ("client_id", "request_id", "at_time_s")
    CLIENT_ID_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    AT_TIME_S_FIELD_NUMBER: _ClassVar[int]
    client_id: str
    request_id: str
    at_time_s: float
    def __init__(self, client_id: _Optional[str] = ..., request_id: _Optional[str] = ..., at_time_s: _Optional[float] = ...) -> None: ...

class ScaleRange(_message.Message):
    __slots__ = ("min", "max")
    MIN_FIELD_NUMBER: _ClassVar[int]
    MAX_FIELD_NUMBER: _ClassVar[int]
    min: float
    max: float
    def __init__(self, min: _Optional[float] = ..., max: _Optional[float] = ...) -> None: ...

class NormalScale(_message.Message):
    __slots__ = ("mean", "standard_deviation", "min", "max")
    MEAN_FIELD_NUMBER: _ClassVar[int]
    STANDARD_DEVIATION_FIELD_NUMBER: _ClassVar[int]
    MIN_FIELD_NUMBER: _ClassVar[int]
    MAX_FIELD_NUMBER: _ClassVar[int]
    mean: float
    standard_deviation: float
    min: float
    max: float
    def __init__(self, mean: _Optional[float] = ..., standard_deviation: _Optional[float] = ..., min: _Optional[float] = ..., max: _Optional[float] = ...) -> None: ...

class LognormalScale(_message.Message):
    __slots__ = ("median", "log_standard_deviation", "min", "max")
    MEDIAN_FIELD_NUMBER: _ClassVar[int]
    LOG_STANDARD_DEVIATION_FIELD_NUMBER: _ClassVar[int]
    MIN_FIELD_NUMBER: _ClassVar[int]
    MAX_FIELD_NUMBER: _ClassVar[int]
    median: float
    log_standard_deviation: float
    min: float
    max: float
    def __init__(self, median: _Optional[float] = ..., log_standard_deviation: _Optional[float] = ..., min: _Optional[float] = ..., max: _Optional[float] = ...) -> None: ...

class ScaleTable(_message.Message):
    __slots__ = ("scales", "weights")
    SCALES_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    scales: _containers.RepeatedScalarFieldContainer[float]
    weights: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, scales: _Optional[_Iterable[float]] = ..., weights: _Optional[_Iterable[float]] = ...) -> None: ...

class InsertRequest(_message.Message):
    __slots__ = ("header", "shape", "material", "poses", "lattice", "random", "deposition", "velocity_m_per_s", "angular_velocity_rad_per_s", "scale", "normal_scale", "lognormal_scale", "scale_table", "frozen")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SHAPE_FIELD_NUMBER: _ClassVar[int]
    MATERIAL_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    LATTICE_FIELD_NUMBER: _ClassVar[int]
    RANDOM_FIELD_NUMBER: _ClassVar[int]
    DEPOSITION_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    ANGULAR_VELOCITY_RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    SCALE_FIELD_NUMBER: _ClassVar[int]
    NORMAL_SCALE_FIELD_NUMBER: _ClassVar[int]
    LOGNORMAL_SCALE_FIELD_NUMBER: _ClassVar[int]
    SCALE_TABLE_FIELD_NUMBER: _ClassVar[int]
    FROZEN_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    shape: str
    material: str
    poses: PosesPlacement
    lattice: LatticePlacement
    random: RandomPlacement
    deposition: DepositionPlacement
    velocity_m_per_s: _data_pb2.Vec3
    angular_velocity_rad_per_s: _data_pb2.Vec3
    scale: ScaleRange
    normal_scale: NormalScale
    lognormal_scale: LognormalScale
    scale_table: ScaleTable
    frozen: bool
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., shape: _Optional[str] = ..., material: _Optional[str] = ..., poses: _Optional[_Union[PosesPlacement, _Mapping]] = ..., lattice: _Optional[_Union[LatticePlacement, _Mapping]] = ..., random: _Optional[_Union[RandomPlacement, _Mapping]] = ..., deposition: _Optional[_Union[DepositionPlacement, _Mapping]] = ..., velocity_m_per_s: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., angular_velocity_rad_per_s: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., scale: _Optional[_Union[ScaleRange, _Mapping]] = ..., normal_scale: _Optional[_Union[NormalScale, _Mapping]] = ..., lognormal_scale: _Optional[_Union[LognormalScale, _Mapping]] = ..., scale_table: _Optional[_Union[ScaleTable, _Mapping]] = ..., frozen: bool = ...) -> None: ...

class PosesPlacement(_message.Message):
    __slots__ = ("positions_m", "orientations_wxyz")
    POSITIONS_M_FIELD_NUMBER: _ClassVar[int]
    ORIENTATIONS_WXYZ_FIELD_NUMBER: _ClassVar[int]
    positions_m: _data_pb2.Column
    orientations_wxyz: _data_pb2.Column
    def __init__(self, positions_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., orientations_wxyz: _Optional[_Union[_data_pb2.Column, _Mapping]] = ...) -> None: ...

class LatticePlacement(_message.Message):
    __slots__ = ("origin_m", "spacing_m", "count_x", "count_y", "count_z", "random_orientation")
    ORIGIN_M_FIELD_NUMBER: _ClassVar[int]
    SPACING_M_FIELD_NUMBER: _ClassVar[int]
    COUNT_X_FIELD_NUMBER: _ClassVar[int]
    COUNT_Y_FIELD_NUMBER: _ClassVar[int]
    COUNT_Z_FIELD_NUMBER: _ClassVar[int]
    RANDOM_ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    origin_m: _data_pb2.Vec3
    spacing_m: _data_pb2.Vec3
    count_x: int
    count_y: int
    count_z: int
    random_orientation: bool
    def __init__(self, origin_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., spacing_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., count_x: _Optional[int] = ..., count_y: _Optional[int] = ..., count_z: _Optional[int] = ..., random_orientation: bool = ...) -> None: ...

class RandomPlacement(_message.Message):
    __slots__ = ("box", "cylinder", "count", "solid_fraction", "fixed_orientation", "attempts")
    BOX_FIELD_NUMBER: _ClassVar[int]
    CYLINDER_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    SOLID_FRACTION_FIELD_NUMBER: _ClassVar[int]
    FIXED_ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    ATTEMPTS_FIELD_NUMBER: _ClassVar[int]
    box: BoxRegion
    cylinder: CylinderRegion
    count: int
    solid_fraction: float
    fixed_orientation: bool
    attempts: int
    def __init__(self, box: _Optional[_Union[BoxRegion, _Mapping]] = ..., cylinder: _Optional[_Union[CylinderRegion, _Mapping]] = ..., count: _Optional[int] = ..., solid_fraction: _Optional[float] = ..., fixed_orientation: bool = ..., attempts: _Optional[int] = ...) -> None: ...

class DepositionPlacement(_message.Message):
    __slots__ = ("box", "count", "fixed_orientation")
    BOX_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    FIXED_ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    box: BoxRegion
    count: int
    fixed_orientation: bool
    def __init__(self, box: _Optional[_Union[BoxRegion, _Mapping]] = ..., count: _Optional[int] = ..., fixed_orientation: bool = ...) -> None: ...

class BoxRegion(_message.Message):
    __slots__ = ("min_m", "max_m")
    MIN_M_FIELD_NUMBER: _ClassVar[int]
    MAX_M_FIELD_NUMBER: _ClassVar[int]
    min_m: _data_pb2.Vec3
    max_m: _data_pb2.Vec3
    def __init__(self, min_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., max_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ...) -> None: ...

class CylinderRegion(_message.Message):
    __slots__ = ("point_m", "axis", "radius_m", "length_m")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    LENGTH_M_FIELD_NUMBER: _ClassVar[int]
    point_m: _data_pb2.Vec3
    axis: _data_pb2.Vec3
    radius_m: float
    length_m: float
    def __init__(self, point_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., axis: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., radius_m: _Optional[float] = ..., length_m: _Optional[float] = ...) -> None: ...

class RemoveRequest(_message.Message):
    __slots__ = ("header", "ids")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    IDS_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    ids: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., ids: _Optional[_Iterable[int]] = ...) -> None: ...

class SetGravityRequest(_message.Message):
    __slots__ = ("header", "gravity_m_per_s2")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_M_PER_S2_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    gravity_m_per_s2: _data_pb2.Vec3
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., gravity_m_per_s2: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ...) -> None: ...

class SetMotionRequest(_message.Message):
    __slots__ = ("header", "boundary", "motion")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    BOUNDARY_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    boundary: str
    motion: Motion
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., boundary: _Optional[str] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class Motion(_message.Message):
    __slots__ = ("fixed", "rotation", "translation", "oscillation", "table", "servo")
    FIXED_FIELD_NUMBER: _ClassVar[int]
    ROTATION_FIELD_NUMBER: _ClassVar[int]
    TRANSLATION_FIELD_NUMBER: _ClassVar[int]
    OSCILLATION_FIELD_NUMBER: _ClassVar[int]
    TABLE_FIELD_NUMBER: _ClassVar[int]
    SERVO_FIELD_NUMBER: _ClassVar[int]
    fixed: FixedMotion
    rotation: RotationMotion
    translation: TranslationMotion
    oscillation: OscillationMotion
    table: TableMotion
    servo: ServoMotion
    def __init__(self, fixed: _Optional[_Union[FixedMotion, _Mapping]] = ..., rotation: _Optional[_Union[RotationMotion, _Mapping]] = ..., translation: _Optional[_Union[TranslationMotion, _Mapping]] = ..., oscillation: _Optional[_Union[OscillationMotion, _Mapping]] = ..., table: _Optional[_Union[TableMotion, _Mapping]] = ..., servo: _Optional[_Union[ServoMotion, _Mapping]] = ...) -> None: ...

class FixedMotion(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class RotationMotion(_message.Message):
    __slots__ = ("point_m", "axis", "constant", "ramp", "oscillation")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    CONSTANT_FIELD_NUMBER: _ClassVar[int]
    RAMP_FIELD_NUMBER: _ClassVar[int]
    OSCILLATION_FIELD_NUMBER: _ClassVar[int]
    point_m: _data_pb2.Vec3
    axis: _data_pb2.Vec3
    constant: ConstantAngularVelocity
    ramp: RampAngularVelocity
    oscillation: OscillationAngularVelocity
    def __init__(self, point_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., axis: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., constant: _Optional[_Union[ConstantAngularVelocity, _Mapping]] = ..., ramp: _Optional[_Union[RampAngularVelocity, _Mapping]] = ..., oscillation: _Optional[_Union[OscillationAngularVelocity, _Mapping]] = ...) -> None: ...

class ConstantAngularVelocity(_message.Message):
    __slots__ = ("rad_per_s",)
    RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    rad_per_s: float
    def __init__(self, rad_per_s: _Optional[float] = ...) -> None: ...

class RampAngularVelocity(_message.Message):
    __slots__ = ("rad_per_s", "duration_s")
    RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    DURATION_S_FIELD_NUMBER: _ClassVar[int]
    rad_per_s: float
    duration_s: float
    def __init__(self, rad_per_s: _Optional[float] = ..., duration_s: _Optional[float] = ...) -> None: ...

class OscillationAngularVelocity(_message.Message):
    __slots__ = ("amplitude_rad_per_s", "frequency_hz", "phase_rad")
    AMPLITUDE_RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    FREQUENCY_HZ_FIELD_NUMBER: _ClassVar[int]
    PHASE_RAD_FIELD_NUMBER: _ClassVar[int]
    amplitude_rad_per_s: float
    frequency_hz: float
    phase_rad: float
    def __init__(self, amplitude_rad_per_s: _Optional[float] = ..., frequency_hz: _Optional[float] = ..., phase_rad: _Optional[float] = ...) -> None: ...

class OscillationMotion(_message.Message):
    __slots__ = ("amplitude_m", "frequency_hz", "phase_rad")
    AMPLITUDE_M_FIELD_NUMBER: _ClassVar[int]
    FREQUENCY_HZ_FIELD_NUMBER: _ClassVar[int]
    PHASE_RAD_FIELD_NUMBER: _ClassVar[int]
    amplitude_m: _data_pb2.Vec3
    frequency_hz: float
    phase_rad: float
    def __init__(self, amplitude_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., frequency_hz: _Optional[float] = ..., phase_rad: _Optional[float] = ...) -> None: ...

class ServoMotion(_message.Message):
    __slots__ = ("direction", "force_n", "gain_m_per_s_per_n", "max_velocity_m_per_s")
    DIRECTION_FIELD_NUMBER: _ClassVar[int]
    FORCE_N_FIELD_NUMBER: _ClassVar[int]
    GAIN_M_PER_S_PER_N_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    direction: _data_pb2.Vec3
    force_n: float
    gain_m_per_s_per_n: float
    max_velocity_m_per_s: float
    def __init__(self, direction: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., force_n: _Optional[float] = ..., gain_m_per_s_per_n: _Optional[float] = ..., max_velocity_m_per_s: _Optional[float] = ...) -> None: ...

class TableMotion(_message.Message):
    __slots__ = ("times_s", "displacements_m")
    TIMES_S_FIELD_NUMBER: _ClassVar[int]
    DISPLACEMENTS_M_FIELD_NUMBER: _ClassVar[int]
    times_s: _containers.RepeatedScalarFieldContainer[float]
    displacements_m: _data_pb2.Column
    def __init__(self, times_s: _Optional[_Iterable[float]] = ..., displacements_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ...) -> None: ...

class TranslationMotion(_message.Message):
    __slots__ = ("velocity_m_per_s",)
    VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    velocity_m_per_s: _data_pb2.Vec3
    def __init__(self, velocity_m_per_s: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ...) -> None: ...

class Loads(_message.Message):
    __slots__ = ("topology_epoch", "ids", "force_n", "torque_n_m", "drag_n_s_per_m", "fluid_velocity_m_per_s", "rotational_drag_n_m_s", "fluid_angular_velocity_rad_per_s", "ramp_s", "valid_until_s")
    TOPOLOGY_EPOCH_FIELD_NUMBER: _ClassVar[int]
    IDS_FIELD_NUMBER: _ClassVar[int]
    FORCE_N_FIELD_NUMBER: _ClassVar[int]
    TORQUE_N_M_FIELD_NUMBER: _ClassVar[int]
    DRAG_N_S_PER_M_FIELD_NUMBER: _ClassVar[int]
    FLUID_VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    ROTATIONAL_DRAG_N_M_S_FIELD_NUMBER: _ClassVar[int]
    FLUID_ANGULAR_VELOCITY_RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    RAMP_S_FIELD_NUMBER: _ClassVar[int]
    VALID_UNTIL_S_FIELD_NUMBER: _ClassVar[int]
    topology_epoch: int
    ids: _data_pb2.Column
    force_n: _data_pb2.Column
    torque_n_m: _data_pb2.Column
    drag_n_s_per_m: _data_pb2.Column
    fluid_velocity_m_per_s: _data_pb2.Column
    rotational_drag_n_m_s: _data_pb2.Column
    fluid_angular_velocity_rad_per_s: _data_pb2.Column
    ramp_s: float
    valid_until_s: float
    def __init__(self, topology_epoch: _Optional[int] = ..., ids: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., force_n: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., torque_n_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., drag_n_s_per_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., fluid_velocity_m_per_s: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., rotational_drag_n_m_s: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., fluid_angular_velocity_rad_per_s: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., ramp_s: _Optional[float] = ..., valid_until_s: _Optional[float] = ...) -> None: ...

class SetLoadsRequest(_message.Message):
    __slots__ = ("header", "loads")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LOADS_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    loads: Loads
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., loads: _Optional[_Union[Loads, _Mapping]] = ...) -> None: ...

class StructuredMesh(_message.Message):
    __slots__ = ("origin_m", "spacing_m", "count_x", "count_y", "count_z", "x_low", "x_high", "y_low", "y_high", "z_low", "z_high")
    ORIGIN_M_FIELD_NUMBER: _ClassVar[int]
    SPACING_M_FIELD_NUMBER: _ClassVar[int]
    COUNT_X_FIELD_NUMBER: _ClassVar[int]
    COUNT_Y_FIELD_NUMBER: _ClassVar[int]
    COUNT_Z_FIELD_NUMBER: _ClassVar[int]
    X_LOW_FIELD_NUMBER: _ClassVar[int]
    X_HIGH_FIELD_NUMBER: _ClassVar[int]
    Y_LOW_FIELD_NUMBER: _ClassVar[int]
    Y_HIGH_FIELD_NUMBER: _ClassVar[int]
    Z_LOW_FIELD_NUMBER: _ClassVar[int]
    Z_HIGH_FIELD_NUMBER: _ClassVar[int]
    origin_m: _data_pb2.Vec3
    spacing_m: _data_pb2.Vec3
    count_x: int
    count_y: int
    count_z: int
    x_low: MeshSide
    x_high: MeshSide
    y_low: MeshSide
    y_high: MeshSide
    z_low: MeshSide
    z_high: MeshSide
    def __init__(self, origin_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., spacing_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., count_x: _Optional[int] = ..., count_y: _Optional[int] = ..., count_z: _Optional[int] = ..., x_low: _Optional[_Union[MeshSide, str]] = ..., x_high: _Optional[_Union[MeshSide, str]] = ..., y_low: _Optional[_Union[MeshSide, str]] = ..., y_high: _Optional[_Union[MeshSide, str]] = ..., z_low: _Optional[_Union[MeshSide, str]] = ..., z_high: _Optional[_Union[MeshSide, str]] = ...) -> None: ...

class PointMesh(_message.Message):
    __slots__ = ("points_m", "volumes_m3")
    POINTS_M_FIELD_NUMBER: _ClassVar[int]
    VOLUMES_M3_FIELD_NUMBER: _ClassVar[int]
    points_m: _data_pb2.Column
    volumes_m3: _data_pb2.Column
    def __init__(self, points_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., volumes_m3: _Optional[_Union[_data_pb2.Column, _Mapping]] = ...) -> None: ...

class FluidDefinition(_message.Message):
    __slots__ = ("density_kg_per_m3", "viscosity_pa_s", "velocity_m_per_s", "structured", "points", "smoothing_length_m", "void_fraction", "least_void_fraction", "drag", "voidage", "lift", "pitching", "rotational_drag", "added_mass_coefficient", "buoyancy", "refresh_steps")
    DENSITY_KG_PER_M3_FIELD_NUMBER: _ClassVar[int]
    VISCOSITY_PA_S_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    STRUCTURED_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    SMOOTHING_LENGTH_M_FIELD_NUMBER: _ClassVar[int]
    VOID_FRACTION_FIELD_NUMBER: _ClassVar[int]
    LEAST_VOID_FRACTION_FIELD_NUMBER: _ClassVar[int]
    DRAG_FIELD_NUMBER: _ClassVar[int]
    VOIDAGE_FIELD_NUMBER: _ClassVar[int]
    LIFT_FIELD_NUMBER: _ClassVar[int]
    PITCHING_FIELD_NUMBER: _ClassVar[int]
    ROTATIONAL_DRAG_FIELD_NUMBER: _ClassVar[int]
    ADDED_MASS_COEFFICIENT_FIELD_NUMBER: _ClassVar[int]
    BUOYANCY_FIELD_NUMBER: _ClassVar[int]
    REFRESH_STEPS_FIELD_NUMBER: _ClassVar[int]
    density_kg_per_m3: float
    viscosity_pa_s: float
    velocity_m_per_s: _data_pb2.Vec3
    structured: StructuredMesh
    points: PointMesh
    smoothing_length_m: float
    void_fraction: float
    least_void_fraction: float
    drag: DragLaw
    voidage: VoidageLaw
    lift: LiftLaw
    pitching: PitchingLaw
    rotational_drag: RotationalDragLaw
    added_mass_coefficient: float
    buoyancy: bool
    refresh_steps: int
    def __init__(self, density_kg_per_m3: _Optional[float] = ..., viscosity_pa_s: _Optional[float] = ..., velocity_m_per_s: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., structured: _Optional[_Union[StructuredMesh, _Mapping]] = ..., points: _Optional[_Union[PointMesh, _Mapping]] = ..., smoothing_length_m: _Optional[float] = ..., void_fraction: _Optional[float] = ..., least_void_fraction: _Optional[float] = ..., drag: _Optional[_Union[DragLaw, str]] = ..., voidage: _Optional[_Union[VoidageLaw, str]] = ..., lift: _Optional[_Union[LiftLaw, str]] = ..., pitching: _Optional[_Union[PitchingLaw, str]] = ..., rotational_drag: _Optional[_Union[RotationalDragLaw, str]] = ..., added_mass_coefficient: _Optional[float] = ..., buoyancy: bool = ..., refresh_steps: _Optional[int] = ...) -> None: ...

class FluidFields(_message.Message):
    __slots__ = ("velocity_m_per_s", "pressure_gradient_pa_per_m", "acceleration_m_per_s2", "vorticity_rad_per_s", "ramp_s")
    VELOCITY_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    PRESSURE_GRADIENT_PA_PER_M_FIELD_NUMBER: _ClassVar[int]
    ACCELERATION_M_PER_S2_FIELD_NUMBER: _ClassVar[int]
    VORTICITY_RAD_PER_S_FIELD_NUMBER: _ClassVar[int]
    RAMP_S_FIELD_NUMBER: _ClassVar[int]
    velocity_m_per_s: _data_pb2.Column
    pressure_gradient_pa_per_m: _data_pb2.Column
    acceleration_m_per_s2: _data_pb2.Column
    vorticity_rad_per_s: _data_pb2.Column
    ramp_s: float
    def __init__(self, velocity_m_per_s: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., pressure_gradient_pa_per_m: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., acceleration_m_per_s2: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., vorticity_rad_per_s: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., ramp_s: _Optional[float] = ...) -> None: ...

class SetFluidRequest(_message.Message):
    __slots__ = ("header", "fluid", "fields")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    FLUID_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    fluid: FluidDefinition
    fields: FluidFields
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., fluid: _Optional[_Union[FluidDefinition, _Mapping]] = ..., fields: _Optional[_Union[FluidFields, _Mapping]] = ...) -> None: ...

class PauseRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class ResumeRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class StepRequest(_message.Message):
    __slots__ = ("header", "steps")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    steps: int
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., steps: _Optional[int] = ...) -> None: ...

class AdvanceRequest(_message.Message):
    __slots__ = ("header", "from_time_s", "from_step", "window_s", "outputs", "loads", "fluid")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    FROM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    FROM_STEP_FIELD_NUMBER: _ClassVar[int]
    WINDOW_S_FIELD_NUMBER: _ClassVar[int]
    OUTPUTS_FIELD_NUMBER: _ClassVar[int]
    LOADS_FIELD_NUMBER: _ClassVar[int]
    FLUID_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    from_time_s: float
    from_step: int
    window_s: float
    outputs: Outputs
    loads: Loads
    fluid: FluidFields
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., from_time_s: _Optional[float] = ..., from_step: _Optional[int] = ..., window_s: _Optional[float] = ..., outputs: _Optional[_Union[Outputs, _Mapping]] = ..., loads: _Optional[_Union[Loads, _Mapping]] = ..., fluid: _Optional[_Union[FluidFields, _Mapping]] = ...) -> None: ...

class Outputs(_message.Message):
    __slots__ = ("columns", "fields", "float_type", "contacts", "exchange")
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    FLOAT_TYPE_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    EXCHANGE_FIELD_NUMBER: _ClassVar[int]
    columns: _containers.RepeatedScalarFieldContainer[str]
    fields: _containers.RepeatedScalarFieldContainer[str]
    float_type: _data_pb2.DataType
    contacts: bool
    exchange: bool
    def __init__(self, columns: _Optional[_Iterable[str]] = ..., fields: _Optional[_Iterable[str]] = ..., float_type: _Optional[_Union[_data_pb2.DataType, str]] = ..., contacts: bool = ..., exchange: bool = ...) -> None: ...

class DefineFieldRequest(_message.Message):
    __slots__ = ("header", "field")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    FIELD_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    field: _data_pb2.FieldDefinition
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., field: _Optional[_Union[_data_pb2.FieldDefinition, _Mapping]] = ...) -> None: ...

class DropFieldRequest(_message.Message):
    __slots__ = ("header", "name")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    name: str
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., name: _Optional[str] = ...) -> None: ...

class DefineOutputRequest(_message.Message):
    __slots__ = ("header", "output")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    OUTPUT_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    output: _data_pb2.OutputDefinition
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., output: _Optional[_Union[_data_pb2.OutputDefinition, _Mapping]] = ...) -> None: ...

class CheckpointRequest(_message.Message):
    __slots__ = ("header", "token", "on_disk")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    ON_DISK_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    token: str
    on_disk: bool
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., token: _Optional[str] = ..., on_disk: bool = ...) -> None: ...

class RestoreRequest(_message.Message):
    __slots__ = ("header", "token")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    token: str
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., token: _Optional[str] = ...) -> None: ...

class ListCheckpointsRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class DropCheckpointRequest(_message.Message):
    __slots__ = ("header", "token")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    token: str
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ..., token: _Optional[str] = ...) -> None: ...

class AcquireLeaseRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class ReleaseLeaseRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class StopRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: CommandHeader
    def __init__(self, header: _Optional[_Union[CommandHeader, _Mapping]] = ...) -> None: ...

class Outcome(_message.Message):
    __slots__ = ("client_id", "request_id", "command", "step", "sim_time_s", "repeated", "error", "applied", "inserted", "removed", "stepped", "advanced", "checkpointed", "restored", "checkpoints")
    CLIENT_ID_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    COMMAND_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    SIM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    REPEATED_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    APPLIED_FIELD_NUMBER: _ClassVar[int]
    INSERTED_FIELD_NUMBER: _ClassVar[int]
    REMOVED_FIELD_NUMBER: _ClassVar[int]
    STEPPED_FIELD_NUMBER: _ClassVar[int]
    ADVANCED_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINTED_FIELD_NUMBER: _ClassVar[int]
    RESTORED_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINTS_FIELD_NUMBER: _ClassVar[int]
    client_id: str
    request_id: str
    command: str
    step: int
    sim_time_s: float
    repeated: bool
    error: Error
    applied: Applied
    inserted: Inserted
    removed: Removed
    stepped: Stepped
    advanced: Advanced
    checkpointed: Checkpointed
    restored: Restored
    checkpoints: Checkpoints
    def __init__(self, client_id: _Optional[str] = ..., request_id: _Optional[str] = ..., command: _Optional[str] = ..., step: _Optional[int] = ..., sim_time_s: _Optional[float] = ..., repeated: bool = ..., error: _Optional[_Union[Error, _Mapping]] = ..., applied: _Optional[_Union[Applied, _Mapping]] = ..., inserted: _Optional[_Union[Inserted, _Mapping]] = ..., removed: _Optional[_Union[Removed, _Mapping]] = ..., stepped: _Optional[_Union[Stepped, _Mapping]] = ..., advanced: _Optional[_Union[Advanced, _Mapping]] = ..., checkpointed: _Optional[_Union[Checkpointed, _Mapping]] = ..., restored: _Optional[_Union[Restored, _Mapping]] = ..., checkpoints: _Optional[_Union[Checkpoints, _Mapping]] = ...) -> None: ...

class Applied(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Inserted(_message.Message):
    __slots__ = ("first_id", "count")
    FIRST_ID_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    first_id: int
    count: int
    def __init__(self, first_id: _Optional[int] = ..., count: _Optional[int] = ...) -> None: ...

class Removed(_message.Message):
    __slots__ = ("count",)
    COUNT_FIELD_NUMBER: _ClassVar[int]
    count: int
    def __init__(self, count: _Optional[int] = ...) -> None: ...

class IdRange(_message.Message):
    __slots__ = ("first_id", "count")
    FIRST_ID_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    first_id: int
    count: int
    def __init__(self, first_id: _Optional[int] = ..., count: _Optional[int] = ...) -> None: ...

class Stepped(_message.Message):
    __slots__ = ("steps_done", "step", "time_reached_s", "stop_reason")
    STEPS_DONE_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    TIME_REACHED_S_FIELD_NUMBER: _ClassVar[int]
    STOP_REASON_FIELD_NUMBER: _ClassVar[int]
    steps_done: int
    step: int
    time_reached_s: float
    stop_reason: StopReason
    def __init__(self, steps_done: _Optional[int] = ..., step: _Optional[int] = ..., time_reached_s: _Optional[float] = ..., stop_reason: _Optional[_Union[StopReason, str]] = ...) -> None: ...

class Advanced(_message.Message):
    __slots__ = ("time_reached_s", "step", "steps_done", "window_steps", "stop_reason", "frame", "fields", "contacts", "exchange")
    TIME_REACHED_S_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    STEPS_DONE_FIELD_NUMBER: _ClassVar[int]
    WINDOW_STEPS_FIELD_NUMBER: _ClassVar[int]
    STOP_REASON_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    EXCHANGE_FIELD_NUMBER: _ClassVar[int]
    time_reached_s: float
    step: int
    steps_done: int
    window_steps: int
    stop_reason: StopReason
    frame: _data_pb2.Frame
    fields: _containers.RepeatedCompositeFieldContainer[_data_pb2.FieldFrame]
    contacts: _data_pb2.ContactFrame
    exchange: _data_pb2.ExchangeFrame
    def __init__(self, time_reached_s: _Optional[float] = ..., step: _Optional[int] = ..., steps_done: _Optional[int] = ..., window_steps: _Optional[int] = ..., stop_reason: _Optional[_Union[StopReason, str]] = ..., frame: _Optional[_Union[_data_pb2.Frame, _Mapping]] = ..., fields: _Optional[_Iterable[_Union[_data_pb2.FieldFrame, _Mapping]]] = ..., contacts: _Optional[_Union[_data_pb2.ContactFrame, _Mapping]] = ..., exchange: _Optional[_Union[_data_pb2.ExchangeFrame, _Mapping]] = ...) -> None: ...

class Checkpoint(_message.Message):
    __slots__ = ("token", "step", "sim_time_s", "particles", "topology_epoch", "state_hash", "bytes", "on_disk")
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    SIM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    PARTICLES_FIELD_NUMBER: _ClassVar[int]
    TOPOLOGY_EPOCH_FIELD_NUMBER: _ClassVar[int]
    STATE_HASH_FIELD_NUMBER: _ClassVar[int]
    BYTES_FIELD_NUMBER: _ClassVar[int]
    ON_DISK_FIELD_NUMBER: _ClassVar[int]
    token: str
    step: int
    sim_time_s: float
    particles: int
    topology_epoch: int
    state_hash: int
    bytes: int
    on_disk: bool
    def __init__(self, token: _Optional[str] = ..., step: _Optional[int] = ..., sim_time_s: _Optional[float] = ..., particles: _Optional[int] = ..., topology_epoch: _Optional[int] = ..., state_hash: _Optional[int] = ..., bytes: _Optional[int] = ..., on_disk: bool = ...) -> None: ...

class Checkpointed(_message.Message):
    __slots__ = ("checkpoint",)
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    checkpoint: Checkpoint
    def __init__(self, checkpoint: _Optional[_Union[Checkpoint, _Mapping]] = ...) -> None: ...

class Restored(_message.Message):
    __slots__ = ("checkpoint",)
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    checkpoint: Checkpoint
    def __init__(self, checkpoint: _Optional[_Union[Checkpoint, _Mapping]] = ...) -> None: ...

class Checkpoints(_message.Message):
    __slots__ = ("checkpoints",)
    CHECKPOINTS_FIELD_NUMBER: _ClassVar[int]
    checkpoints: _containers.RepeatedCompositeFieldContainer[Checkpoint]
    def __init__(self, checkpoints: _Optional[_Iterable[_Union[Checkpoint, _Mapping]]] = ...) -> None: ...

class Error(_message.Message):
    __slots__ = ("code", "path", "message")
    CODE_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    code: ErrorCode
    path: str
    message: str
    def __init__(self, code: _Optional[_Union[ErrorCode, str]] = ..., path: _Optional[str] = ..., message: _Optional[str] = ...) -> None: ...
