//! The kernels of scattered data, as functions of a squared distance (METHOD §2.1).

use crate::envelope::GroupKernel;

/// A kernel, as a function of s, the squared scaled distance; r is its root (METHOD §2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// `-r`.
    Linear,
    /// `s ln(s) / 2`, 0 at 0.
    ThinPlate,
    /// `r³`.
    Cubic,
    /// `-r⁵`.
    Quintic,
    /// `-√(1 + s)`.
    Multiquadric,
    /// `1 / √(1 + s)`.
    InverseMultiquadric,
    /// `1 / (1 + s)`.
    InverseQuadratic,
    /// `e^-s`.
    Gaussian,
    /// `e^-r`.
    Matern12,
    /// `(1 + a) e^-a`, a = √(3 s).
    Matern32,
    /// `(1 + a + a²/3) e^-a`, a = √(5 s).
    Matern52,
    /// `(1 - r)^(l + 1) ((l + 1) r + 1)` where r < 1, else 0.
    Wendland {
        /// Half of the dimensions in which it is positive definite, rounded down, and 2.
        l: u8,
    },
    /// `1 - r^n` where r < 1, else 0: other tools' falloffs, n = 1, 3 or 5. No fit solves with it.
    Hat {
        /// The power, n.
        power: u8,
    },
}

impl Kernel {
    /// One of each, Wendland's for up to 3 dimensions.
    pub const ALL: [Self; 15] = [
        Self::Linear,
        Self::ThinPlate,
        Self::Cubic,
        Self::Quintic,
        Self::Multiquadric,
        Self::InverseMultiquadric,
        Self::InverseQuadratic,
        Self::Gaussian,
        Self::Matern12,
        Self::Matern32,
        Self::Matern52,
        Self::Wendland { l: 3 },
        Self::Hat { power: 1 },
        Self::Hat { power: 3 },
        Self::Hat { power: 5 },
    ];

    /// Returns its number in the file: its place in METHOD §2.1's table, 13 of a hat.
    pub const fn number(self) -> u8 {
        match self {
            Self::Linear => 1,
            Self::ThinPlate => 2,
            Self::Cubic => 3,
            Self::Quintic => 4,
            Self::Multiquadric => 5,
            Self::InverseMultiquadric => 6,
            Self::InverseQuadratic => 7,
            Self::Gaussian => 8,
            Self::Matern12 => 9,
            Self::Matern32 => 10,
            Self::Matern52 => 11,
            Self::Wendland { .. } => 12,
            Self::Hat { .. } => 13,
        }
    }

    /// Returns its parameter in the file: l, a power, or 0.
    pub const fn parameter(self) -> u8 {
        match self {
            Self::Wendland { l } => l,
            Self::Hat { power } => power,
            _ => 0,
        }
    }

    /// Returns the kernel of a number and a parameter, if there is one: l is 2 to 66, a power 1, 3 or 5.
    pub fn from_number(number: u8, parameter: u8) -> Option<Self> {
        match (number, parameter) {
            (12, l @ 2..=66) => Some(Self::Wendland { l }),
            (13, power @ (1 | 3 | 5)) => Some(Self::Hat { power }),
            (1..=11, 0) => Self::ALL.get(usize::from(number).checked_sub(1)?).copied(),
            _ => None,
        }
    }

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::ThinPlate => "thin plate",
            Self::Cubic => "cubic",
            Self::Quintic => "quintic",
            Self::Multiquadric => "multiquadric",
            Self::InverseMultiquadric => "inverse multiquadric",
            Self::InverseQuadratic => "inverse quadratic",
            Self::Gaussian => "gaussian",
            Self::Matern12 => "Matérn 1/2",
            Self::Matern32 => "Matérn 3/2",
            Self::Matern52 => "Matérn 5/2",
            Self::Wendland { .. } => "Wendland",
            Self::Hat { .. } => "hat",
        }
    }
}

impl From<GroupKernel> for Kernel {
    fn from(kernel: GroupKernel) -> Self {
        match kernel {
            GroupKernel::Gaussian => Self::Gaussian,
            GroupKernel::Matern12 => Self::Matern12,
            GroupKernel::Matern32 => Self::Matern32,
            GroupKernel::Matern52 => Self::Matern52,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_parameters_name_one_kernel() {
        for kernel in Kernel::ALL {
            assert_eq!(Kernel::from_number(kernel.number(), kernel.parameter()), Some(kernel));
        }
        for (number, parameter) in [(0, 0), (8, 1), (12, 1), (12, 67), (13, 0), (13, 2), (14, 0)] {
            assert_eq!(Kernel::from_number(number, parameter), None);
        }
    }

    #[test]
    fn kernels_of_groups_keep_their_numbers() {
        for kernel in GroupKernel::ALL {
            let all = Kernel::from(kernel);
            assert_eq!((all.number(), all.name()), (kernel.number(), kernel.name()));
        }
    }
}
