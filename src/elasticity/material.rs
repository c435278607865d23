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

    /// Constrained (oedometric) modulus M_c = λ + 2G [Pa].
    pub fn constrained(&self) -> f64 {
        self.lambda() + 2.0 * self.shear()
    }
}
