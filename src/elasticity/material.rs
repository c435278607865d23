//! Isotropic elastic constants.

/// An isotropic linear elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young's modulus E [Pa].
    pub young: f64,
    /// Poisson's ratio ν [-].
    pub poisson: f64,
}

impl Elastic {
    /// Lamé's first constant λ = Eν / ((1+ν)(1−2ν)) [Pa].
    pub fn lambda(&self) -> f64 {
        self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// Shear modulus G = E / (2(1+ν)) [Pa].
    pub fn shear(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Bulk modulus K = E / (3(1−2ν)) [Pa].
    pub fn bulk(&self) -> f64 {
        self.young / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// The same K with φ G for G: `E = 9KG/(3K + G)`, `ν = (3K − 2G)/(6K + 2G)`; the bits of this one where φ = 1.
    #[must_use]
    pub fn with_shear_share(&self, share: f64) -> Self {
        if share == 1.0 {
            return *self;
        }
        let (bulk, shear) = (self.bulk(), share * self.shear());
        Self {
            young: 9.0 * bulk * shear / (3.0 * bulk + shear),
            poisson: (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear),
        }
    }

    /// Constrained (oedometric) modulus M_c = λ + 2G [Pa].
    pub fn constrained(&self) -> f64 {
        self.lambda() + 2.0 * self.shear()
    }
}
