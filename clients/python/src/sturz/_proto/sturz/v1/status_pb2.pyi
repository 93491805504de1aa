from . import command_pb2 as _command_pb2
from . import data_pb2 as _data_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class RunState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    RUN_STATE_UNSPECIFIED: _ClassVar[RunState]
    RUN_STATE_RUNNING: _ClassVar[RunState]
    RUN_STATE_PAUSED: _ClassVar[RunState]
    RUN_STATE_ADVANCING: _ClassVar[RunState]
    RUN_STATE_FAILED: _ClassVar[RunState]
    RUN_STATE_ENDED: _ClassVar[RunState]

class EventKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    EVENT_KIND_UNSPECIFIED: _ClassVar[EventKind]
    EVENT_KIND_COMMAND: _ClassVar[EventKind]
    EVENT_KIND_STARTED: _ClassVar[EventKind]
    EVENT_KIND_PAUSED: _ClassVar[EventKind]
    EVENT_KIND_RESUMED: _ClassVar[EventKind]
    EVENT_KIND_FAILED: _ClassVar[EventKind]
    EVENT_KIND_ENDED: _ClassVar[EventKind]
    EVENT_KIND_PARTICLES: _ClassVar[EventKind]
    EVENT_KIND_FIELD: _ClassVar[EventKind]
    EVENT_KIND_CHECKPOINT: _ClassVar[EventKind]
    EVENT_KIND_RESTORED: _ClassVar[EventKind]
    EVENT_KIND_LEASE: _ClassVar[EventKind]
    EVENT_KIND_JOURNAL: _ClassVar[EventKind]
    EVENT_KIND_WARNING: _ClassVar[EventKind]
    EVENT_KIND_OUTPUT: _ClassVar[EventKind]
    EVENT_KIND_STAGE: _ClassVar[EventKind]
    EVENT_KIND_INFLOW: _ClassVar[EventKind]

class WarningKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    WARNING_KIND_UNSPECIFIED: _ClassVar[WarningKind]
    WARNING_KIND_LARGE_OVERLAP: _ClassVar[WarningKind]
    WARNING_KIND_FAST_PARTICLE: _ClassVar[WarningKind]
    WARNING_KIND_DEEP_ROUNDING: _ClassVar[WarningKind]
    WARNING_KIND_ROTATION_NOT_CONVERGED: _ClassVar[WarningKind]
    WARNING_KIND_TIME_STEP: _ClassVar[WarningKind]

class LeaseChange(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    LEASE_CHANGE_UNSPECIFIED: _ClassVar[LeaseChange]
    LEASE_CHANGE_ACQUIRED: _ClassVar[LeaseChange]
    LEASE_CHANGE_RELEASED: _ClassVar[LeaseChange]
    LEASE_CHANGE_LOST: _ClassVar[LeaseChange]

class Severity(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SEVERITY_UNSPECIFIED: _ClassVar[Severity]
    SEVERITY_INFO: _ClassVar[Severity]
    SEVERITY_WARNING: _ClassVar[Severity]
    SEVERITY_ERROR: _ClassVar[Severity]
RUN_STATE_UNSPECIFIED: RunState
RUN_STATE_RUNNING: RunState
RUN_STATE_PAUSED: RunState
RUN_STATE_ADVANCING: RunState
RUN_STATE_FAILED: RunState
RUN_STATE_ENDED: RunState
EVENT_KIND_UNSPECIFIED: EventKind
EVENT_KIND_COMMAND: EventKind
EVENT_KIND_STARTED: EventKind
EVENT_KIND_PAUSED: EventKind
EVENT_KIND_RESUMED: EventKind
EVENT_KIND_FAILED: EventKind
EVENT_KIND_ENDED: EventKind
EVENT_KIND_PARTICLES: EventKind
EVENT_KIND_FIELD: EventKind
EVENT_KIND_CHECKPOINT: EventKind
EVENT_KIND_RESTORED: EventKind
EVENT_KIND_LEASE: EventKind
EVENT_KIND_JOURNAL: EventKind
EVENT_KIND_WARNING: EventKind
EVENT_KIND_OUTPUT: EventKind
EVENT_KIND_STAGE: EventKind
EVENT_KIND_INFLOW: EventKind
WARNING_KIND_UNSPECIFIED: WarningKind
WARNING_KIND_LARGE_OVERLAP: WarningKind
WARNING_KIND_FAST_PARTICLE: WarningKind
WARNING_KIND_DEEP_ROUNDING: WarningKind
WARNING_KIND_ROTATION_NOT_CONVERGED: WarningKind
WARNING_KIND_TIME_STEP: WarningKind
LEASE_CHANGE_UNSPECIFIED: LeaseChange
LEASE_CHANGE_ACQUIRED: LeaseChange
LEASE_CHANGE_RELEASED: LeaseChange
LEASE_CHANGE_LOST: LeaseChange
SEVERITY_UNSPECIFIED: Severity
SEVERITY_INFO: Severity
SEVERITY_WARNING: Severity
SEVERITY_ERROR: Severity

class Info(_message.Message):
    __slots__ = ("version", "schema_version", "instance", "run_id", "scene", "pid", "state", "failure", "sim_time_s", "step", "time_step_s", "particles", "topology_epoch", "state_hash", "gravity_m_per_s2", "domain", "fields", "boundaries", "materials", "shapes", "scene_toml", "threads", "lease_holder", "outputs")
    VERSION_FIELD_NUMBER: _ClassVar[int]
    SCHEMA_VERSION_FIELD_NUMBER: _ClassVar[int]
    INSTANCE_FIELD_NUMBER: _ClassVar[int]
    RUN_ID_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    PID_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    FAILURE_FIELD_NUMBER: _ClassVar[int]
    SIM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    TIME_STEP_S_FIELD_NUMBER: _ClassVar[int]
    PARTICLES_FIELD_NUMBER: _ClassVar[int]
    TOPOLOGY_EPOCH_FIELD_NUMBER: _ClassVar[int]
    STATE_HASH_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_M_PER_S2_FIELD_NUMBER: _ClassVar[int]
    DOMAIN_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    BOUNDARIES_FIELD_NUMBER: _ClassVar[int]
    MATERIALS_FIELD_NUMBER: _ClassVar[int]
    SHAPES_FIELD_NUMBER: _ClassVar[int]
    SCENE_TOML_FIELD_NUMBER: _ClassVar[int]
    THREADS_FIELD_NUMBER: _ClassVar[int]
    LEASE_HOLDER_FIELD_NUMBER: _ClassVar[int]
    OUTPUTS_FIELD_NUMBER: _ClassVar[int]
    version: str
    schema_version: int
    instance: str
    run_id: str
    scene: str
    pid: int
    state: RunState
    failure: str
    sim_time_s: float
    step: int
    time_step_s: float
    particles: int
    topology_epoch: int
    state_hash: int
    gravity_m_per_s2: _data_pb2.Vec3
    domain: Domain
    fields: _containers.RepeatedCompositeFieldContainer[_data_pb2.FieldDefinition]
    boundaries: _containers.RepeatedCompositeFieldContainer[BoundaryInfo]
    materials: _containers.RepeatedScalarFieldContainer[str]
    shapes: _containers.RepeatedScalarFieldContainer[str]
    scene_toml: str
    threads: int
    lease_holder: str
    outputs: _containers.RepeatedCompositeFieldContainer[_data_pb2.OutputDefinition]
    def __init__(self, version: _Optional[str] = ..., schema_version: _Optional[int] = ..., instance: _Optional[str] = ..., run_id: _Optional[str] = ..., scene: _Optional[str] = ..., pid: _Optional[int] = ..., state: _Optional[_Union[RunState, str]] = ..., failure: _Optional[str] = ..., sim_time_s: _Optional[float] = ..., step: _Optional[int] = ..., time_step_s: _Optional[float] = ..., particles: _Optional[int] = ..., topology_epoch: _Optional[int] = ..., state_hash: _Optional[int] = ..., gravity_m_per_s2: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., domain: _Optional[_Union[Domain, _Mapping]] = ..., fields: _Optional[_Iterable[_Union[_data_pb2.FieldDefinition, _Mapping]]] = ..., boundaries: _Optional[_Iterable[_Union[BoundaryInfo, _Mapping]]] = ..., materials: _Optional[_Iterable[str]] = ..., shapes: _Optional[_Iterable[str]] = ..., scene_toml: _Optional[str] = ..., threads: _Optional[int] = ..., lease_holder: _Optional[str] = ..., outputs: _Optional[_Iterable[_Union[_data_pb2.OutputDefinition, _Mapping]]] = ...) -> None: ...

class Domain(_message.Message):
    __slots__ = ("min_m", "max_m", "periodic_x", "periodic_y", "periodic_z")
    MIN_M_FIELD_NUMBER: _ClassVar[int]
    MAX_M_FIELD_NUMBER: _ClassVar[int]
    PERIODIC_X_FIELD_NUMBER: _ClassVar[int]
    PERIODIC_Y_FIELD_NUMBER: _ClassVar[int]
    PERIODIC_Z_FIELD_NUMBER: _ClassVar[int]
    min_m: _data_pb2.Vec3
    max_m: _data_pb2.Vec3
    periodic_x: bool
    periodic_y: bool
    periodic_z: bool
    def __init__(self, min_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., max_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., periodic_x: bool = ..., periodic_y: bool = ..., periodic_z: bool = ...) -> None: ...

class BoundaryInfo(_message.Message):
    __slots__ = ("name", "material", "plane", "cylinder_inside", "cylinder_outside", "mesh")
    NAME_FIELD_NUMBER: _ClassVar[int]
    MATERIAL_FIELD_NUMBER: _ClassVar[int]
    PLANE_FIELD_NUMBER: _ClassVar[int]
    CYLINDER_INSIDE_FIELD_NUMBER: _ClassVar[int]
    CYLINDER_OUTSIDE_FIELD_NUMBER: _ClassVar[int]
    MESH_FIELD_NUMBER: _ClassVar[int]
    name: str
    material: str
    plane: PlaneGeometry
    cylinder_inside: CylinderInsideGeometry
    cylinder_outside: CylinderOutsideGeometry
    mesh: MeshGeometry
    def __init__(self, name: _Optional[str] = ..., material: _Optional[str] = ..., plane: _Optional[_Union[PlaneGeometry, _Mapping]] = ..., cylinder_inside: _Optional[_Union[CylinderInsideGeometry, _Mapping]] = ..., cylinder_outside: _Optional[_Union[CylinderOutsideGeometry, _Mapping]] = ..., mesh: _Optional[_Union[MeshGeometry, _Mapping]] = ...) -> None: ...

class PlaneGeometry(_message.Message):
    __slots__ = ("point_m", "normal")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    point_m: _data_pb2.Vec3
    normal: _data_pb2.Vec3
    def __init__(self, point_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., normal: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ...) -> None: ...

class CylinderInsideGeometry(_message.Message):
    __slots__ = ("point_m", "axis", "radius_m")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    point_m: _data_pb2.Vec3
    axis: _data_pb2.Vec3
    radius_m: float
    def __init__(self, point_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., axis: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., radius_m: _Optional[float] = ...) -> None: ...

class CylinderOutsideGeometry(_message.Message):
    __slots__ = ("point_m", "axis", "radius_m")
    POINT_M_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    point_m: _data_pb2.Vec3
    axis: _data_pb2.Vec3
    radius_m: float
    def __init__(self, point_m: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., axis: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., radius_m: _Optional[float] = ...) -> None: ...

class MeshGeometry(_message.Message):
    __slots__ = ("vertices", "triangles")
    VERTICES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    vertices: _data_pb2.Column
    triangles: _data_pb2.Column
    def __init__(self, vertices: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., triangles: _Optional[_Union[_data_pb2.Column, _Mapping]] = ...) -> None: ...

class Features(_message.Message):
    __slots__ = ("commands", "columns", "field_quantities", "capabilities", "limits", "scene_schema_json", "contact_columns")
    COMMANDS_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    FIELD_QUANTITIES_FIELD_NUMBER: _ClassVar[int]
    CAPABILITIES_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    SCENE_SCHEMA_JSON_FIELD_NUMBER: _ClassVar[int]
    CONTACT_COLUMNS_FIELD_NUMBER: _ClassVar[int]
    commands: _containers.RepeatedScalarFieldContainer[str]
    columns: _containers.RepeatedScalarFieldContainer[str]
    field_quantities: _containers.RepeatedScalarFieldContainer[str]
    capabilities: _containers.RepeatedScalarFieldContainer[str]
    limits: Limits
    scene_schema_json: str
    contact_columns: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, commands: _Optional[_Iterable[str]] = ..., columns: _Optional[_Iterable[str]] = ..., field_quantities: _Optional[_Iterable[str]] = ..., capabilities: _Optional[_Iterable[str]] = ..., limits: _Optional[_Union[Limits, _Mapping]] = ..., scene_schema_json: _Optional[str] = ..., contact_columns: _Optional[_Iterable[str]] = ...) -> None: ...

class Limits(_message.Message):
    __slots__ = ("message_bytes", "insertion_particles", "particles", "queue_length", "remembered_requests", "fields", "field_cells", "checkpoints", "checkpoint_bytes", "checkpoint_files", "clients", "pairs", "open_requests")
    MESSAGE_BYTES_FIELD_NUMBER: _ClassVar[int]
    INSERTION_PARTICLES_FIELD_NUMBER: _ClassVar[int]
    PARTICLES_FIELD_NUMBER: _ClassVar[int]
    QUEUE_LENGTH_FIELD_NUMBER: _ClassVar[int]
    REMEMBERED_REQUESTS_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    FIELD_CELLS_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINTS_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_BYTES_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_FILES_FIELD_NUMBER: _ClassVar[int]
    CLIENTS_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    OPEN_REQUESTS_FIELD_NUMBER: _ClassVar[int]
    message_bytes: int
    insertion_particles: int
    particles: int
    queue_length: int
    remembered_requests: int
    fields: int
    field_cells: int
    checkpoints: int
    checkpoint_bytes: int
    checkpoint_files: int
    clients: int
    pairs: int
    open_requests: int
    def __init__(self, message_bytes: _Optional[int] = ..., insertion_particles: _Optional[int] = ..., particles: _Optional[int] = ..., queue_length: _Optional[int] = ..., remembered_requests: _Optional[int] = ..., fields: _Optional[int] = ..., field_cells: _Optional[int] = ..., checkpoints: _Optional[int] = ..., checkpoint_bytes: _Optional[int] = ..., checkpoint_files: _Optional[int] = ..., clients: _Optional[int] = ..., pairs: _Optional[int] = ..., open_requests: _Optional[int] = ...) -> None: ...

class Plan(_message.Message):
    __slots__ = ("lines",)
    LINES_FIELD_NUMBER: _ClassVar[int]
    lines: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, lines: _Optional[_Iterable[str]] = ...) -> None: ...

class Shapes(_message.Message):
    __slots__ = ("epoch", "shapes")
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    SHAPES_FIELD_NUMBER: _ClassVar[int]
    epoch: int
    shapes: _containers.RepeatedCompositeFieldContainer[Shape]
    def __init__(self, epoch: _Optional[int] = ..., shapes: _Optional[_Iterable[_Union[Shape, _Mapping]]] = ...) -> None: ...

class Shape(_message.Message):
    __slots__ = ("name", "kind", "volume_m3", "bounding_radius_m", "principal_moments_per_density_m5", "given_from_body", "vertices", "triangles", "parameters", "parts")
    NAME_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    VOLUME_M3_FIELD_NUMBER: _ClassVar[int]
    BOUNDING_RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    PRINCIPAL_MOMENTS_PER_DENSITY_M5_FIELD_NUMBER: _ClassVar[int]
    GIVEN_FROM_BODY_FIELD_NUMBER: _ClassVar[int]
    VERTICES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    PARAMETERS_FIELD_NUMBER: _ClassVar[int]
    PARTS_FIELD_NUMBER: _ClassVar[int]
    name: str
    kind: str
    volume_m3: float
    bounding_radius_m: float
    principal_moments_per_density_m5: _data_pb2.Vec3
    given_from_body: _data_pb2.Pose
    vertices: _data_pb2.Column
    triangles: _data_pb2.Column
    parameters: _containers.RepeatedCompositeFieldContainer[Parameter]
    parts: int
    def __init__(self, name: _Optional[str] = ..., kind: _Optional[str] = ..., volume_m3: _Optional[float] = ..., bounding_radius_m: _Optional[float] = ..., principal_moments_per_density_m5: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., given_from_body: _Optional[_Union[_data_pb2.Pose, _Mapping]] = ..., vertices: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., triangles: _Optional[_Union[_data_pb2.Column, _Mapping]] = ..., parameters: _Optional[_Iterable[_Union[Parameter, _Mapping]]] = ..., parts: _Optional[int] = ...) -> None: ...

class Parameter(_message.Message):
    __slots__ = ("name", "value")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    name: str
    value: float
    def __init__(self, name: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...

class Report(_message.Message):
    __slots__ = ("header", "state", "particles", "touching_pairs", "touching_boundary_pairs", "contact_points", "contact_points_smooth", "contact_points_vertex_face", "contact_points_edge_edge", "neighbour_rebuilds", "energy", "momentum_kg_m_per_s", "internal_force_residual_n", "largest_overlap_m", "largest_overlap_ratio", "largest_overlap_ratio_so_far", "time_step_s", "critical_time_step_s", "contact_duration_s", "warnings", "stages", "sim_s_per_wall_s", "steps_per_wall_s", "streams", "state_hash", "progress", "wall_s", "largest_overlap_over_rounding", "present_critical_time_step_s", "longest_pause_s")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    PARTICLES_FIELD_NUMBER: _ClassVar[int]
    TOUCHING_PAIRS_FIELD_NUMBER: _ClassVar[int]
    TOUCHING_BOUNDARY_PAIRS_FIELD_NUMBER: _ClassVar[int]
    CONTACT_POINTS_FIELD_NUMBER: _ClassVar[int]
    CONTACT_POINTS_SMOOTH_FIELD_NUMBER: _ClassVar[int]
    CONTACT_POINTS_VERTEX_FACE_FIELD_NUMBER: _ClassVar[int]
    CONTACT_POINTS_EDGE_EDGE_FIELD_NUMBER: _ClassVar[int]
    NEIGHBOUR_REBUILDS_FIELD_NUMBER: _ClassVar[int]
    ENERGY_FIELD_NUMBER: _ClassVar[int]
    MOMENTUM_KG_M_PER_S_FIELD_NUMBER: _ClassVar[int]
    INTERNAL_FORCE_RESIDUAL_N_FIELD_NUMBER: _ClassVar[int]
    LARGEST_OVERLAP_M_FIELD_NUMBER: _ClassVar[int]
    LARGEST_OVERLAP_RATIO_FIELD_NUMBER: _ClassVar[int]
    LARGEST_OVERLAP_RATIO_SO_FAR_FIELD_NUMBER: _ClassVar[int]
    TIME_STEP_S_FIELD_NUMBER: _ClassVar[int]
    CRITICAL_TIME_STEP_S_FIELD_NUMBER: _ClassVar[int]
    CONTACT_DURATION_S_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    STAGES_FIELD_NUMBER: _ClassVar[int]
    SIM_S_PER_WALL_S_FIELD_NUMBER: _ClassVar[int]
    STEPS_PER_WALL_S_FIELD_NUMBER: _ClassVar[int]
    STREAMS_FIELD_NUMBER: _ClassVar[int]
    STATE_HASH_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    WALL_S_FIELD_NUMBER: _ClassVar[int]
    LARGEST_OVERLAP_OVER_ROUNDING_FIELD_NUMBER: _ClassVar[int]
    PRESENT_CRITICAL_TIME_STEP_S_FIELD_NUMBER: _ClassVar[int]
    LONGEST_PAUSE_S_FIELD_NUMBER: _ClassVar[int]
    header: _data_pb2.Header
    state: RunState
    particles: int
    touching_pairs: int
    touching_boundary_pairs: int
    contact_points: int
    contact_points_smooth: int
    contact_points_vertex_face: int
    contact_points_edge_edge: int
    neighbour_rebuilds: int
    energy: EnergyBalance
    momentum_kg_m_per_s: _data_pb2.Vec3
    internal_force_residual_n: float
    largest_overlap_m: float
    largest_overlap_ratio: float
    largest_overlap_ratio_so_far: float
    time_step_s: float
    critical_time_step_s: float
    contact_duration_s: float
    warnings: WarningCounts
    stages: _containers.RepeatedCompositeFieldContainer[StageCost]
    sim_s_per_wall_s: float
    steps_per_wall_s: float
    streams: _containers.RepeatedCompositeFieldContainer[StreamCounts]
    state_hash: int
    progress: Progress
    wall_s: float
    largest_overlap_over_rounding: float
    present_critical_time_step_s: float
    longest_pause_s: float
    def __init__(self, header: _Optional[_Union[_data_pb2.Header, _Mapping]] = ..., state: _Optional[_Union[RunState, str]] = ..., particles: _Optional[int] = ..., touching_pairs: _Optional[int] = ..., touching_boundary_pairs: _Optional[int] = ..., contact_points: _Optional[int] = ..., contact_points_smooth: _Optional[int] = ..., contact_points_vertex_face: _Optional[int] = ..., contact_points_edge_edge: _Optional[int] = ..., neighbour_rebuilds: _Optional[int] = ..., energy: _Optional[_Union[EnergyBalance, _Mapping]] = ..., momentum_kg_m_per_s: _Optional[_Union[_data_pb2.Vec3, _Mapping]] = ..., internal_force_residual_n: _Optional[float] = ..., largest_overlap_m: _Optional[float] = ..., largest_overlap_ratio: _Optional[float] = ..., largest_overlap_ratio_so_far: _Optional[float] = ..., time_step_s: _Optional[float] = ..., critical_time_step_s: _Optional[float] = ..., contact_duration_s: _Optional[float] = ..., warnings: _Optional[_Union[WarningCounts, _Mapping]] = ..., stages: _Optional[_Iterable[_Union[StageCost, _Mapping]]] = ..., sim_s_per_wall_s: _Optional[float] = ..., steps_per_wall_s: _Optional[float] = ..., streams: _Optional[_Iterable[_Union[StreamCounts, _Mapping]]] = ..., state_hash: _Optional[int] = ..., progress: _Optional[_Union[Progress, _Mapping]] = ..., wall_s: _Optional[float] = ..., largest_overlap_over_rounding: _Optional[float] = ..., present_critical_time_step_s: _Optional[float] = ..., longest_pause_s: _Optional[float] = ...) -> None: ...

class EnergyBalance(_message.Message):
    __slots__ = ("kinetic_translation_j", "kinetic_rotation_j", "potential_j", "elastic_j", "dissipated_normal_j", "dissipated_friction_j", "work_boundaries_j", "work_commands_j", "residual_j", "dissipated_local_j", "work_loads_j")
    KINETIC_TRANSLATION_J_FIELD_NUMBER: _ClassVar[int]
    KINETIC_ROTATION_J_FIELD_NUMBER: _ClassVar[int]
    POTENTIAL_J_FIELD_NUMBER: _ClassVar[int]
    ELASTIC_J_FIELD_NUMBER: _ClassVar[int]
    DISSIPATED_NORMAL_J_FIELD_NUMBER: _ClassVar[int]
    DISSIPATED_FRICTION_J_FIELD_NUMBER: _ClassVar[int]
    WORK_BOUNDARIES_J_FIELD_NUMBER: _ClassVar[int]
    WORK_COMMANDS_J_FIELD_NUMBER: _ClassVar[int]
    RESIDUAL_J_FIELD_NUMBER: _ClassVar[int]
    DISSIPATED_LOCAL_J_FIELD_NUMBER: _ClassVar[int]
    WORK_LOADS_J_FIELD_NUMBER: _ClassVar[int]
    kinetic_translation_j: float
    kinetic_rotation_j: float
    potential_j: float
    elastic_j: float
    dissipated_normal_j: float
    dissipated_friction_j: float
    work_boundaries_j: float
    work_commands_j: float
    residual_j: float
    dissipated_local_j: float
    work_loads_j: float
    def __init__(self, kinetic_translation_j: _Optional[float] = ..., kinetic_rotation_j: _Optional[float] = ..., potential_j: _Optional[float] = ..., elastic_j: _Optional[float] = ..., dissipated_normal_j: _Optional[float] = ..., dissipated_friction_j: _Optional[float] = ..., work_boundaries_j: _Optional[float] = ..., work_commands_j: _Optional[float] = ..., residual_j: _Optional[float] = ..., dissipated_local_j: _Optional[float] = ..., work_loads_j: _Optional[float] = ...) -> None: ...

class WarningCounts(_message.Message):
    __slots__ = ("rotation_not_converged", "large_overlap", "fast_particle", "deep_rounding")
    ROTATION_NOT_CONVERGED_FIELD_NUMBER: _ClassVar[int]
    LARGE_OVERLAP_FIELD_NUMBER: _ClassVar[int]
    FAST_PARTICLE_FIELD_NUMBER: _ClassVar[int]
    DEEP_ROUNDING_FIELD_NUMBER: _ClassVar[int]
    rotation_not_converged: int
    large_overlap: int
    fast_particle: int
    deep_rounding: int
    def __init__(self, rotation_not_converged: _Optional[int] = ..., large_overlap: _Optional[int] = ..., fast_particle: _Optional[int] = ..., deep_rounding: _Optional[int] = ...) -> None: ...

class StageCost(_message.Message):
    __slots__ = ("name", "s_per_step")
    NAME_FIELD_NUMBER: _ClassVar[int]
    S_PER_STEP_FIELD_NUMBER: _ClassVar[int]
    name: str
    s_per_step: float
    def __init__(self, name: _Optional[str] = ..., s_per_step: _Optional[float] = ...) -> None: ...

class StreamCounts(_message.Message):
    __slots__ = ("name", "offered", "published", "dropped")
    NAME_FIELD_NUMBER: _ClassVar[int]
    OFFERED_FIELD_NUMBER: _ClassVar[int]
    PUBLISHED_FIELD_NUMBER: _ClassVar[int]
    DROPPED_FIELD_NUMBER: _ClassVar[int]
    name: str
    offered: int
    published: int
    dropped: int
    def __init__(self, name: _Optional[str] = ..., offered: _Optional[int] = ..., published: _Optional[int] = ..., dropped: _Optional[int] = ...) -> None: ...

class Progress(_message.Message):
    __slots__ = ("from_time_s", "to_time_s", "steps_done", "steps_total")
    FROM_TIME_S_FIELD_NUMBER: _ClassVar[int]
    TO_TIME_S_FIELD_NUMBER: _ClassVar[int]
    STEPS_DONE_FIELD_NUMBER: _ClassVar[int]
    STEPS_TOTAL_FIELD_NUMBER: _ClassVar[int]
    from_time_s: float
    to_time_s: float
    steps_done: int
    steps_total: int
    def __init__(self, from_time_s: _Optional[float] = ..., to_time_s: _Optional[float] = ..., steps_done: _Optional[int] = ..., steps_total: _Optional[int] = ...) -> None: ...

class GuardWarning(_message.Message):
    __slots__ = ("kind", "count", "total", "particle_id", "value", "limit")
    KIND_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    TOTAL_FIELD_NUMBER: _ClassVar[int]
    PARTICLE_ID_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    LIMIT_FIELD_NUMBER: _ClassVar[int]
    kind: WarningKind
    count: int
    total: int
    particle_id: int
    value: float
    limit: float
    def __init__(self, kind: _Optional[_Union[WarningKind, str]] = ..., count: _Optional[int] = ..., total: _Optional[int] = ..., particle_id: _Optional[int] = ..., value: _Optional[float] = ..., limit: _Optional[float] = ...) -> None: ...

class Event(_message.Message):
    __slots__ = ("header", "kind", "severity", "message", "outcome", "name", "inserted", "removed", "warning", "lease", "checkpoint", "output")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    SEVERITY_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    OUTCOME_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    INSERTED_FIELD_NUMBER: _ClassVar[int]
    REMOVED_FIELD_NUMBER: _ClassVar[int]
    WARNING_FIELD_NUMBER: _ClassVar[int]
    LEASE_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    OUTPUT_FIELD_NUMBER: _ClassVar[int]
    header: _data_pb2.Header
    kind: EventKind
    severity: Severity
    message: str
    outcome: _command_pb2.Outcome
    name: str
    inserted: _command_pb2.IdRange
    removed: _containers.RepeatedCompositeFieldContainer[_command_pb2.IdRange]
    warning: GuardWarning
    lease: LeaseChange
    checkpoint: _command_pb2.Checkpoint
    output: _data_pb2.OutputDefinition
    def __init__(self, header: _Optional[_Union[_data_pb2.Header, _Mapping]] = ..., kind: _Optional[_Union[EventKind, str]] = ..., severity: _Optional[_Union[Severity, str]] = ..., message: _Optional[str] = ..., outcome: _Optional[_Union[_command_pb2.Outcome, _Mapping]] = ..., name: _Optional[str] = ..., inserted: _Optional[_Union[_command_pb2.IdRange, _Mapping]] = ..., removed: _Optional[_Iterable[_Union[_command_pb2.IdRange, _Mapping]]] = ..., warning: _Optional[_Union[GuardWarning, _Mapping]] = ..., lease: _Optional[_Union[LeaseChange, str]] = ..., checkpoint: _Optional[_Union[_command_pb2.Checkpoint, _Mapping]] = ..., output: _Optional[_Union[_data_pb2.OutputDefinition, _Mapping]] = ...) -> None: ...
