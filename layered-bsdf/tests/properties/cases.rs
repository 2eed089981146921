//! The one list: every distribution function with parameters worth testing, and what it promises.

use crate::math::direction;
use crate::sphere::Bins;
use layered_bsdf::prelude::*;

/// A tree in a situation.
#[derive(Clone)]
pub struct Case {
    /// For messages.
    pub name: String,
    /// The tree.
    pub tree: Tree<f32>,
    /// Media and sides.
    pub point: ShadingPoint,
    /// All energy leaves, within 1e-3.
    pub lossless: bool,
    /// f(a, b)/ηb² = f(b, a)/ηa².
    pub reciprocal: bool,
    /// Beyond MDL.
    pub options: BsdfOptions,
}

/// Everything that the evaluator needs for a case.
pub struct Setup {
    /// The flat program.
    pub program: Program,
    /// Its parameters.
    pub params: Params,
    /// Media and sides.
    pub point: ShadingPoint,
}

impl Case {
    /// A case that is reciprocal and not lossless, without options.
    pub fn new(name: impl Into<String>, tree: Tree<f32>, point: ShadingPoint) -> Self {
        let options = BsdfOptions::default();
        Self { name: name.into(), tree, point, lossless: false, reciprocal: true, options }
    }

    /// Lays the tree out.
    pub fn setup(&self) -> Setup {
        let (program, params) = LayerProgram::with_values_and_options(&self.tree, self.options, self.point)
            .expect("the list holds small trees");
        Setup { program: program.with_tables(crate::measured::tables()), params, point: self.point }
    }

    /// Bins that are narrow where the lobes seen from `wo` may have peaks.
    pub fn bins(&self, wo: Vec3f) -> Bins {
        let thin = self.point.flags & POINT_THIN_WALLED != 0;
        let eta = if thin { 1.0 } else { f64::from(self.point.ior_far.x / self.point.ior_near.x) };
        let sends_back = matches!(self.tree, Tree::Glossy { model: GlossyModel::Backscattering, .. });
        Bins::new(if sends_back { vec3f(-wo.x, -wo.y, wo.z) } else { wo }, eta)
    }
}

impl Setup {
    /// Value and density.
    pub fn eval(&mut self, wo: Vec3f, wi: Vec3f) -> BsdfValue {
        bsdf_eval(&mut self.program, &mut self.params, self.point, wo, wi)
    }

    /// A sample.
    pub fn sample(&mut self, wo: Vec3f, u: [f32; 3]) -> BsdfSample {
        bsdf_sample(&mut self.program, &mut self.params, self.point, wo, vec3f(u[0], u[1], u[2]))
    }

    /// The albedo.
    pub fn albedo(&mut self, wo: Vec3f) -> BsdfAlbedo {
        bsdf_albedo(&mut self.program, &mut self.params, self.point, wo)
    }

    /// The auxiliary outputs.
    pub fn auxiliary(&mut self, wo: Vec3f) -> BsdfAuxiliary {
        bsdf_auxiliary(&mut self.program, &mut self.params, self.point, wo)
    }
}

/// Seen from the medium of index `near`, with `far` behind, no bump.
pub fn point(near: f32, far: f32, flags: u32) -> ShadingPoint {
    shading_point(vec3f(0.0, 0.0, 1.0), vec3f(near, near, near), vec3f(far, far, far), flags)
}

/// Directions that every case is looked at from: cosines down to 0.01.
pub fn views() -> [Vec3f; 4] {
    [direction(1.0, 0.0), direction(0.7, 0.4), direction(0.2, 2.5), direction(0.01, 4.0)]
}

/// White, as a tint.
pub const WHITE: [f32; 3] = [1.0; 3];

/// All cases; of those, where `LACQUER_CASES` is set, the ones with that text in their name.
pub fn cases() -> Vec<Case> {
    let mut list = Vec::new();
    for kind in KINDS {
        kind.cases(&mut list);
    }
    crate::optional::cases(&mut list);
    if let Ok(text) = std::env::var("LACQUER_CASES") {
        list.retain(|case| case.name.contains(&text));
    }
    list
}

/// Every constructor of [`Tree`]; `kind_of` makes a missing one a compile error.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Black,
    DiffuseReflection,
    DiffuseTransmission,
    Specular,
    GgxSmith,
    Glossy,
    Sheen,
    DustyDiffuse,
    MicroflakeSheen,
    MeasuredBsdf,
    Tint,
    Scale,
    DirectionalFactor,
    FresnelFactor,
    MeasuredFactor,
    MeasuredPicture,
    CoatAbsorption,
    ThinFilm,
    Layer,
    Emission,
    Volume,
}

const KINDS: [Kind; 21] = [
    Kind::Black,
    Kind::DiffuseReflection,
    Kind::DiffuseTransmission,
    Kind::Specular,
    Kind::GgxSmith,
    Kind::Glossy,
    Kind::Sheen,
    Kind::DustyDiffuse,
    Kind::MicroflakeSheen,
    Kind::MeasuredBsdf,
    Kind::Tint,
    Kind::Scale,
    Kind::DirectionalFactor,
    Kind::FresnelFactor,
    Kind::MeasuredFactor,
    Kind::MeasuredPicture,
    Kind::CoatAbsorption,
    Kind::ThinFilm,
    Kind::Layer,
    Kind::Emission,
    Kind::Volume,
];

fn kind_of(tree: &Tree<f32>) -> Kind {
    match tree {
        Tree::Black => Kind::Black,
        Tree::DiffuseReflection { .. } => Kind::DiffuseReflection,
        Tree::DiffuseTransmission { .. } => Kind::DiffuseTransmission,
        Tree::Specular { .. } => Kind::Specular,
        Tree::GgxSmith { .. } => Kind::GgxSmith,
        Tree::Glossy { .. } => Kind::Glossy,
        Tree::Sheen { .. } => Kind::Sheen,
        Tree::DustyDiffuse { .. } => Kind::DustyDiffuse,
        Tree::MicroflakeSheen { .. } => Kind::MicroflakeSheen,
        Tree::MeasuredBsdf { .. } => Kind::MeasuredBsdf,
        Tree::Tint { .. } => Kind::Tint,
        Tree::Scale { .. } => Kind::Scale,
        Tree::DirectionalFactor { .. } => Kind::DirectionalFactor,
        Tree::FresnelFactor { .. } => Kind::FresnelFactor,
        Tree::MeasuredFactor { .. } => Kind::MeasuredFactor,
        Tree::MeasuredPicture { .. } => Kind::MeasuredPicture,
        Tree::CoatAbsorption { .. } => Kind::CoatAbsorption,
        Tree::ThinFilm { .. } => Kind::ThinFilm,
        Tree::Layer { .. } => Kind::Layer,
        // These have tests of their own: they are no BSDFs.
        Tree::DiffuseEdf | Tree::SpotEdf { .. } => Kind::Emission,
        Tree::AnisotropicVdf { .. } | Tree::FogVdf { .. } => Kind::Volume,
    }
}

#[test]
fn every_kind_of_node_is_a_case() {
    let list = cases();
    for kind in KINDS {
        let found = list.iter().any(|case| kind_of(&case.tree) == kind);
        assert!(found || matches!(kind, Kind::Emission | Kind::Volume), "{kind:?} has no case");
    }
}

const MODES: [(ScatterMode, &str); 3] = [
    (ScatterMode::Reflect, "reflect"),
    (ScatterMode::Transmit, "transmit"),
    (ScatterMode::ReflectTransmit, "reflect_transmit"),
];

/// Situations for what can transmit: into glass, out of it, and a thin sheet.
fn transmission_points() -> [(ShadingPoint, &'static str); 3] {
    [
        (point(1.0, 1.5, 0), "into 1.5"),
        (point(1.5, 1.0, POINT_INSIDE), "out of 1.5"),
        (point(1.0, 1.5, POINT_THIN_WALLED), "thin"),
    ]
}

impl Kind {
    fn cases(self, list: &mut Vec<Case>) {
        match self {
            Kind::Black => {
                add(list, "black", Tree::Black, point(1.0, 1.0, 0), false);
            }
            Kind::DiffuseReflection => {
                add(list, "diffuse", diffuse(0.0), point(1.0, 1.0, 0), true);
                add(list, "diffuse roughness 0.6", diffuse(0.6), point(1.0, 1.0, 0), false);
                let full =
                    Tree::DiffuseReflection { tint: WHITE, roughness: 1.0, multiscatter_tint: Some(WHITE) };
                add(list, "diffuse roughness 1, multiple scattering", full, point(1.0, 1.0, 0), true);
            }
            Kind::DiffuseTransmission => {
                let tree = Tree::DiffuseTransmission { tint: WHITE };
                // Between different media Lambert's law on both sides would not be reciprocal.
                add(list, "diffuse transmission", tree, point(1.0, 1.0, 0), true);
            }
            Kind::Specular => {
                for (mode, name) in MODES {
                    for (point, side) in transmission_points() {
                        let tree = Tree::Specular { tint: WHITE, mode };
                        add(list, &format!("specular {name} {side}"), tree, point, true);
                    }
                }
            }
            Kind::GgxSmith => ggx_cases(list),
            Kind::Glossy => {
                MODELS.into_iter().for_each(|model| glossy_cases(list, model));
                compensated_cases(list);
            }
            Kind::Sheen => {
                for roughness in [1.0, 0.3, 0.05] {
                    let lobe = Tree::Sheen { tint: WHITE, roughness };
                    add(list, &format!("sheen {roughness}"), lobe.clone(), point(1.0, 1.5, 0), false);
                    let over = layer(Curve::Sheen { roughness }, 1.0, None, lobe, diffuse(0.0));
                    add(list, &format!("sheen {roughness} over diffuse"), over, point(1.0, 1.5, 0), false);
                }
            }
            Kind::DustyDiffuse => {
                let dust = |tint| Tree::DustyDiffuse { tint };
                add(list, "dusty diffuse, white", dust(WHITE), point(1.0, 1.0, 0), true);
                add(list, "dusty diffuse", dust([0.8, 0.3, 0.02]), point(1.0, 1.0, 0), false);
            }
            Kind::MicroflakeSheen => {
                for roughness in [1.0, 0.4, 0.1] {
                    let lobe = Tree::MicroflakeSheen { tint: WHITE, roughness };
                    let base = Tree::DustyDiffuse { tint: WHITE };
                    let over = layer(Curve::Microflake { roughness }, 1.0, None, lobe.clone(), base);
                    let air = point(1.0, 1.5, 0);
                    for (name, tree) in [("alone", lobe), ("over dust", over)] {
                        add(list, &format!("microflake sheen {roughness} {name}"), tree, air, false);
                        list.last_mut().expect("just added").reciprocal = false;
                    }
                }
            }
            Kind::MeasuredBsdf => crate::measured::lobe_cases(list),
            Kind::MeasuredPicture => crate::measured::picture_cases(list),
            Kind::Tint => {
                let tree = Tree::Tint {
                    tint: [0.8, 0.5, 0.2],
                    transmission: Some([0.1, 0.6, 0.9]),
                    base: Box::new(ggx(0.4, 0.4, ScatterMode::ReflectTransmit)),
                };
                add(list, "tint", tree, point(1.0, 1.5, 0), false);
            }
            Kind::Scale => {
                let tree = Tree::Scale { factor: [0.5, 0.25, 0.125], base: Box::new(diffuse(0.0)) };
                add(list, "scale", tree, point(1.0, 1.0, 0), false);
            }
            Kind::DirectionalFactor => {
                for f82_factor in [None, Some([0.4, 0.6, 0.8])] {
                    let tree = Tree::DirectionalFactor {
                        normal_tint: [0.9, 0.6, 0.3],
                        grazing_tint: WHITE,
                        f82_factor,
                        exponent: 5.0,
                        base: Box::new(ggx(0.3, 0.3, ScatterMode::Reflect)),
                    };
                    add(
                        list,
                        &format!("directional factor, f82 {f82_factor:?}"),
                        tree,
                        point(1.0, 1.0, 0),
                        false,
                    );
                }
            }
            Kind::FresnelFactor => {
                let tree = Tree::FresnelFactor {
                    ior: GOLD.0,
                    extinction: GOLD.1,
                    base: Box::new(ggx(0.3, 0.3, ScatterMode::Reflect)),
                };
                add(list, "fresnel factor", tree, point(1.0, 1.0, 0), false);
            }
            Kind::MeasuredFactor => {
                for (name, curve) in [("five", CURVE.to_vec()), ("one", vec![[0.5; 3]]), ("no", vec![])] {
                    let base = Box::new(ggx(0.3, 0.3, ScatterMode::ReflectTransmit));
                    let tree = Tree::MeasuredFactor { curve, base };
                    add(list, &format!("measured factor of {name} colors"), tree, point(1.0, 1.5, 0), false);
                    // The angle at the half vector is not the same from both sides.
                    list.last_mut().expect("just added").reciprocal = false;
                }
            }
            Kind::CoatAbsorption => {
                let transmitting = layer(
                    Curve::Constant,
                    0.5,
                    None,
                    diffuse(0.0),
                    Tree::DiffuseTransmission { tint: WHITE },
                );
                for (ior, thickness) in [(1.5, 0.4), (0.8, 0.1), (1.0, 0.0)] {
                    let tree = Tree::CoatAbsorption {
                        ior: [ior, 1.1 * ior, 1.2 * ior],
                        coefficient: [0.5, 1.0, 2.0],
                        thickness,
                        base: Box::new(transmitting.clone()),
                    };
                    let name = format!("coat absorption {ior}, thickness {thickness}");
                    add(list, &name, tree, point(1.0, 1.0, 0), thickness == 0.0);
                }
            }
            Kind::ThinFilm => film_cases(list),
            Kind::Layer => layer_cases(list),
            Kind::Emission | Kind::Volume => {}
        }
    }
}

/// Gold, roughly: index of refraction and extinction.
pub const GOLD: ([f32; 3], [f32; 3]) = ([0.17, 0.35, 1.5], [3.1, 2.7, 1.9]);

/// A measured curve that rises and falls.
const CURVE: [[f32; 3]; 5] =
    [[0.1, 0.9, 0.5], [0.7, 0.2, 0.5], [0.3, 0.6, 0.9], [1.0, 0.1, 0.0], [0.5, 1.0, 1.0]];

/// A film on `base`.
pub fn film(thickness: f32, ior: [f32; 3], base: Tree<f32>) -> Tree<f32> {
    Tree::ThinFilm { thickness, ior, base: Box::new(base) }
}

/// Films on everything that they change.
fn film_cases(list: &mut Vec<Case>) {
    let both = ScatterMode::ReflectTransmit;
    let mirror = Tree::Specular { tint: WHITE, mode: both };
    for (at, side) in transmission_points() {
        let name = |what: &str| format!("film on {what} {side}");
        add(list, &name("specular"), film(300.0, [1.33; 3], mirror.clone()), at, true);
        add(list, &name("ggx"), film(300.0, [1.8; 3], ggx(0.3, 0.3, both)), at, false);
    }
    let air = point(1.0, 1.5, 0);
    for (thickness, ior) in [(1.0, [1.8; 3]), (5e3, [1.3, 1.4, 1.6])] {
        let vcavities = glossy(GlossyModel::BeckmannVcavities, (0.5, 0.2), both);
        add(
            list,
            &format!("film of {thickness} nm on V-cavities"),
            film(thickness, ior, vcavities),
            air,
            false,
        );
    }
    // A soap bubble.
    let bubble = point(1.0, 1.0, POINT_THIN_WALLED);
    add(list, "film on nothing, specular", film(350.0, [1.33; 3], mirror), bubble, true);
    for (at, side) in [(bubble, "thin"), (point(1.0, 1.0, 0), "solid")] {
        add(
            list,
            &format!("film on nothing, rough, {side}"),
            film(350.0, [1.33; 3], ggx(0.2, 0.2, both)),
            at,
            false,
        );
        // Equal indices are moved apart, by as much from either side.
        list.last_mut().expect("just added").reciprocal = false;
    }
    let gold = |base| Tree::FresnelFactor { ior: GOLD.0, extinction: GOLD.1, base: Box::new(base) };
    let metal = gold(ggx(0.3, 0.3, ScatterMode::Reflect));
    add(list, "film on gold", film(250.0, [1.7; 3], metal), point(1.0, 1.0, 0), false);
    let factor = Tree::DirectionalFactor {
        normal_tint: [0.9, 0.6, 0.1],
        grazing_tint: WHITE,
        f82_factor: Some([0.4, 0.6, 0.8]),
        exponent: 5.0,
        base: Box::new(ggx(0.3, 0.3, ScatterMode::Reflect)),
    };
    add(list, "film on a directional factor", film(250.0, [1.7; 3], factor), point(1.0, 1.0, 0), false);
    let custom = Curve::Custom {
        normal_reflectivity: [0.04, 0.3, 0.6],
        grazing_reflectivity: WHITE,
        f82_factor: None,
        exponent: 5.0,
    };
    for (name, curve) in [("fresnel", Curve::Fresnel { ior: 1.7 }), ("custom curve", custom)] {
        for roughness in [0.05, 0.6] {
            let coat = layer(
                curve.clone(),
                1.0,
                Some([0.1, 0.0, 1.0]),
                ggx(roughness, roughness, ScatterMode::Reflect),
                diffuse(0.0),
            );
            let name = format!("film on {name} layer, roughness {roughness}");
            add(list, &name, film(400.0, [2.2; 3], coat), point(1.0, 1.5, 0), false);
            list.last_mut().expect("just added").reciprocal = false;
        }
    }
}

fn ggx_cases(list: &mut Vec<Case>) {
    for alpha in [1.0, 0.5, 0.1, 0.01, 1e-3] {
        let tree = ggx(alpha, alpha, ScatterMode::Reflect);
        add(list, &format!("ggx reflect {alpha}"), tree, point(1.0, 1.5, 0), false);
        for (mode, name) in &MODES[1..] {
            for (point, side) in transmission_points() {
                add(list, &format!("ggx {name} {alpha} {side}"), ggx(alpha, alpha, *mode), point, false);
            }
        }
    }
    for (u, v) in [(1.0, 0.05), (0.02, 0.4), (1.0, 1e-3)] {
        for (mode, name) in MODES {
            let tree = Tree::GgxSmith {
                tint: WHITE,
                roughness_u: u,
                roughness_v: v,
                mode,
                tangent: Some([0.6, 0.7, 0.2]),
            };
            add(list, &format!("ggx {name} {u} x {v}"), tree, point(1.0, 1.5, 0), false);
        }
    }
}

const MODELS: [GlossyModel; 6] = [
    GlossyModel::BeckmannSmith,
    GlossyModel::GgxVcavities,
    GlossyModel::BeckmannVcavities,
    GlossyModel::Simple,
    GlossyModel::Ward,
    GlossyModel::Backscattering,
];

/// A white lobe, isotropic unless it has a tangent.
pub fn glossy(model: GlossyModel, roughness: (f32, f32), mode: ScatterMode) -> Tree<f32> {
    let tangent = (roughness.0 != roughness.1).then_some([0.6, 0.7, 0.2]);
    Tree::Glossy {
        model,
        tint: WHITE,
        multiscatter_tint: None,
        roughness_u: roughness.0,
        roughness_v: roughness.1,
        mode,
        tangent,
    }
}

fn glossy_cases(list: &mut Vec<Case>, model: GlossyModel) {
    let transmits = !matches!(model, GlossyModel::Ward | GlossyModel::Backscattering);
    let air = point(1.0, 1.5, 0);
    for alpha in [1.0, 0.2, 0.01, 1e-3] {
        if alpha < 0.01 && model != GlossyModel::Backscattering {
            continue;
        }
        let tree = glossy(model, (alpha, alpha), ScatterMode::Reflect);
        add(list, &format!("{model:?} reflect {alpha}"), tree, air, false);
    }
    let tree = glossy(model, (0.8, 0.05), ScatterMode::Reflect);
    add(list, &format!("{model:?} reflect 0.8 x 0.05"), tree, air, false);
    if transmits {
        for (point, side) in transmission_points() {
            let tree = glossy(model, (0.3, 0.3), ScatterMode::ReflectTransmit);
            add(list, &format!("{model:?} reflect_transmit 0.3 {side}"), tree, point, false);
        }
        let tree = glossy(model, (0.5, 0.1), ScatterMode::Transmit);
        add(list, &format!("{model:?} transmit 0.5 x 0.1"), tree, air, false);
    }
}

/// Every glossy lobe with white multiple scattering.
fn compensated_cases(list: &mut Vec<Case>) {
    let compensated = |model, roughness, mode| match glossy(model, roughness, mode) {
        Tree::Glossy { tint, roughness_u, roughness_v, tangent, .. } => {
            let multiscatter_tint = Some(WHITE);
            Tree::Glossy { model, tint, multiscatter_tint, roughness_u, roughness_v, mode, tangent }
        }
        tree => tree,
    };
    let air = point(1.0, 1.5, 0);
    for model in MODELS.into_iter().chain([GlossyModel::GgxSmith]) {
        let exact = model == GlossyModel::GgxSmith;
        for alpha in [1.0, 0.85, 0.5, 0.25, 0.12, 0.05, 0.02] {
            let tree = compensated(model, (alpha, alpha), ScatterMode::Reflect);
            // Where hardly anything is lost, the error of the fit is.
            add(list, &format!("{model:?} compensated {alpha}"), tree, air, exact && alpha > 0.1);
        }
        for (u, v) in [(0.9, 0.2), (1.0, 0.5), (0.5, 0.1), (1.0, 0.05), (0.1, 0.02), (0.6, 0.55)] {
            let tree = compensated(model, (u, v), ScatterMode::Reflect);
            add(list, &format!("{model:?} compensated {u} x {v}"), tree, air, false);
        }
    }
    for model in [GlossyModel::GgxSmith, GlossyModel::Simple] {
        for (mode, name) in &MODES[2..] {
            for (point, side) in transmission_points() {
                let tree = compensated(model, (0.5, 0.5), *mode);
                let lossless = model == GlossyModel::GgxSmith && side == "thin";
                add(list, &format!("{model:?} compensated {name} 0.5 {side}"), tree, point, lossless);
            }
        }
    }
}

fn layer_cases(list: &mut Vec<Case>) {
    let air = point(1.0, 1.5, 0);
    let inside = point(1.5, 1.0, POINT_INSIDE);
    let custom = |f82_factor| Curve::Custom {
        normal_reflectivity: [0.04, 0.05, 0.06],
        grazing_reflectivity: [1.0, 0.9, 0.8],
        f82_factor,
        exponent: 5.0,
    };
    for (name, curve) in [
        ("weighted", Curve::Constant),
        ("fresnel", Curve::Fresnel { ior: 1.5 }),
        ("color fresnel", Curve::ColorFresnel { ior: [1.4, 1.6, 2.0] }),
        ("custom curve", custom(None)),
        ("custom curve f82", custom(Some([0.5, 0.6, 0.7]))),
        ("measured curve", Curve::Measured { values: CURVE.to_vec() }),
        ("empty measured curve", Curve::Measured { values: vec![] }),
    ] {
        let coat = layer(curve.clone(), 0.7, None, ggx(0.2, 0.2, ScatterMode::Reflect), diffuse(0.0));
        add(list, &format!("{name} layer, glossy over diffuse"), coat, air, false);
        let mirror = Tree::Specular { tint: WHITE, mode: ScatterMode::Reflect };
        let coat = layer(curve, 0.7, None, mirror, diffuse(0.0));
        add(list, &format!("{name} layer, mirror over diffuse"), coat, air, name == "weighted");
    }
    let bumped = layer(
        Curve::Fresnel { ior: 1.5 },
        1.0,
        Some([0.2, -0.1, 0.9]),
        ggx(0.2, 0.2, ScatterMode::Reflect),
        diffuse(0.4),
    );
    add(list, "fresnel layer with a normal", bumped, air, false);
    list.last_mut().expect("just added").reciprocal = false;
    let glass = layer(
        Curve::Fresnel { ior: 1.2 },
        1.0,
        None,
        Tree::Specular { tint: WHITE, mode: ScatterMode::Reflect },
        ggx(0.3, 0.3, ScatterMode::ReflectTransmit),
    );
    for (name, point) in [("over", air), ("under", inside)] {
        add(list, &format!("fresnel layer {name} rough glass"), glass.clone(), point, false);
        // The layer's curve is looked up on both sides of the glass with the angle there.
        list.last_mut().expect("just added").reciprocal = false;
    }
    let mix = layer(
        Curve::Constant,
        0.3,
        None,
        layer(Curve::Constant, 0.5, None, diffuse(0.0), Tree::DiffuseTransmission { tint: WHITE }),
        layer(
            Curve::Constant,
            0.8,
            None,
            Tree::Specular { tint: WHITE, mode: ScatterMode::Transmit },
            diffuse(0.0),
        ),
    );
    add(list, "mix of mixes", mix, point(1.0, 1.0, 0), true);
    add(list, "deep chain", chain(12), air, false);
}

/// Alternating layers, left and right heavy, to exercise the order of visits.
fn chain(depth: u32) -> Tree<f32> {
    (0..depth).fold(diffuse(0.0), |tree, i| {
        let other = ggx(0.1 + 0.05 * i as f32, 0.2, ScatterMode::Reflect);
        let (top, base) = if i % 3 == 0 { (tree, other) } else { (other, tree) };
        layer(
            Curve::Custom {
                normal_reflectivity: [0.3; 3],
                grazing_reflectivity: [0.9; 3],
                f82_factor: None,
                exponent: 3.0,
            },
            0.6,
            None,
            top,
            base,
        )
    })
}

/// White diffuse reflection.
pub fn diffuse(roughness: f32) -> Tree<f32> {
    Tree::DiffuseReflection { tint: WHITE, roughness, multiscatter_tint: None }
}

/// A white GGX lobe without a tangent.
pub fn ggx(roughness_u: f32, roughness_v: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::GgxSmith { tint: WHITE, roughness_u, roughness_v, mode, tangent: None }
}

/// A layer over a base.
pub fn layer(
    curve: Curve<f32>,
    weight: f32,
    normal: Option<[f32; 3]>,
    layer: Tree<f32>,
    base: Tree<f32>,
) -> Tree<f32> {
    Tree::Layer { curve, weight: [weight; 3], normal, layer: Box::new(layer), base: Box::new(base) }
}

fn add(list: &mut Vec<Case>, name: &str, tree: Tree<f32>, point: ShadingPoint, lossless: bool) {
    list.push(Case { lossless, ..Case::new(name, tree, point) });
}
