//! Isotropic elastic rock.

/// Elastic constants of an unbounded or layered rock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rock {
    /// Young's modulus E [Pa].
    pub young: f64,
    /// Poisson's ratio ν [1].
    pub poisson: f64,
}

impl Rock {
    /// Shear modulus `G = E/(2(1+ν))` [Pa].
    pub fn shear(self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// `(1 − ν²)/E` [1/Pa]: the compliance of plane strain, which every crack below is proportional to.
    pub fn plane_strain_compliance(self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young
    }
}

#[cfg(test)]
mod tests {
    use super::Rock;

    #[test]
    fn constants_of_a_granite() {
        let rock = Rock {
            young: 25e9,
            poisson: 0.25,
        };
        approx::assert_relative_eq!(rock.shear(), 10e9, max_relative = 1e-15);
        approx::assert_relative_eq!(
            rock.plane_strain_compliance(),
            3.75e-11,
            max_relative = 1e-15
        );
    }
}
