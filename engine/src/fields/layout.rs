//! Which sums a definition keeps at each point, and where.
//!
//! All of them are extensive: they add up over particles, samples and blocks, and every quantity is made of them last.

use super::quantity::FieldQuantity;

/// A few sums of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Group {
    /// m
    Mass,
    /// V
    Volume,
    /// m u, u the velocity less a reference.
    Momentum,
    /// m u u
    Kinetic,
    /// m omega
    Spin,
    /// W S W^T with W the matrix of omega x and S the Euler tensor.
    Rotational,
    /// (3 n n - 1) / 2
    Axes,
    /// 1
    Number,
    /// Touching neighbours by kind.
    Coordination,
    /// Of the sphere of equal volume.
    Diameter,
    /// m (r - r_i)(r - r_i)
    SecondMoment,
    /// d/dr_k of m phi
    MassGradient,
    /// d/dr_k of m u_a phi: row a, column k.
    MomentumGradient,
    /// V of the true shape.
    ShapeVolume,
    /// m v' v' with v' about the field at the particle.
    Peculiar,
    /// f b between particles.
    PairStress,
    /// f b at boundaries.
    BoundaryStress,
    /// Force on boundaries.
    WallForce,
}

/// How components turn with the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Not.
    Scalars(usize),
    /// As a vector.
    Vector,
    /// xx, xy, xz, yy, yz, zz.
    Symmetric,
    /// Row-major.
    Tensor,
}

/// Kinds of neighbours that are counted.
pub(super) const KINDS: usize = 8;

impl Group {
    const COUNT: usize = 18;
    /// In the order of their places.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Mass,
        Self::Volume,
        Self::Momentum,
        Self::Kinetic,
        Self::Spin,
        Self::Rotational,
        Self::Axes,
        Self::Number,
        Self::Coordination,
        Self::Diameter,
        Self::SecondMoment,
        Self::MassGradient,
        Self::MomentumGradient,
        Self::ShapeVolume,
        Self::Peculiar,
        Self::PairStress,
        Self::BoundaryStress,
        Self::WallForce,
    ];

    pub fn kind(self) -> Kind {
        match self {
            Self::Mass | Self::Volume | Self::Number | Self::Diameter | Self::ShapeVolume => Kind::Scalars(1),
            Self::Coordination => Kind::Scalars(KINDS),
            Self::Momentum | Self::Spin | Self::MassGradient | Self::WallForce => Kind::Vector,
            Self::Kinetic | Self::Rotational | Self::Axes | Self::SecondMoment | Self::Peculiar => Kind::Symmetric,
            Self::MomentumGradient | Self::PairStress | Self::BoundaryStress => Kind::Tensor,
        }
    }

    /// What each particle brings, times the kernel.
    pub fn is_of_particles(self) -> bool {
        (self as usize) < Self::SecondMoment as usize
    }

    /// What takes contacts.
    pub fn is_of_contacts(self) -> bool {
        matches!(self, Self::Coordination | Self::PairStress | Self::BoundaryStress | Self::WallForce)
    }
}

impl Kind {
    pub fn size(self) -> usize {
        match self {
            Self::Scalars(n) => n,
            Self::Vector => 3,
            Self::Symmetric => 6,
            Self::Tensor => 9,
        }
    }
}

/// Where the sums of a point are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    places: [Option<usize>; Group::COUNT],
    /// Sums of a point.
    pub size: usize,
    /// The first so many are of particles.
    pub of_particles: usize,
}

impl Layout {
    pub fn of(quantities: &[FieldQuantity]) -> Self {
        let (mut places, mut size, mut of_particles) = ([None; Group::COUNT], 0, 0);
        for group in Group::ALL {
            if quantities.iter().any(|quantity| quantity.groups().contains(&group)) {
                places[group as usize] = Some(size);
                size += group.kind().size();
                if group.is_of_particles() {
                    of_particles = size;
                }
            }
        }
        Self { places, size, of_particles }
    }

    /// Where a group begins.
    pub fn place(&self, group: Group) -> Option<usize> {
        self.places[group as usize]
    }

    pub fn has(&self, group: Group) -> bool {
        self.place(group).is_some()
    }

    /// Groups that are there, with their places.
    pub fn groups(&self) -> impl Iterator<Item = (Group, usize)> + '_ {
        Group::ALL.into_iter().filter_map(|group| self.place(group).map(|at| (group, at)))
    }
}
