//! What a program may do beyond MDL's definition.

/// Options of a program; all off by default, which is MDL as defined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct BsdfOptions {
    /// Smith masking and shadowing at correlated heights (E. Heitz, JCGT 3(2), 2014, eq. 99) instead of apart.
    /// GGX and Beckmann; refraction divides by the same sum.
    pub correlated_masking: bool,
    /// Lobes without a multiple scattering tint scatter what single scattering loses in their own tint.
    pub multiple_scattering: bool,
    /// The base of a layer with a curve gets all that the layer does not reflect, seen from `wo`. Not
    /// reciprocal. Layers whose parameters vary over the surface, and those seen from inside or from another
    /// medium than air, stay as MDL has them.
    pub conserving_layers: bool,
}

impl BsdfOptions {
    /// Every option with its name and whether it is on.
    pub fn list(&self) -> [(&'static str, bool); 3] {
        [
            ("correlated-masking", self.correlated_masking),
            ("multiple-scattering", self.multiple_scattering),
            ("conserving-layers", self.conserving_layers),
        ]
    }
}
