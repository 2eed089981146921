//! Nothing ever is NaN, infinite or negative, whatever the parameters, directions and random numbers.

use crate::cases::{Case, cases, ggx, layer, point};
use crate::math::{Random, direction};
use layered_bsdf::prelude::*;

/// Random numbers at the ends of their range and of their resolution.
const UNITS: [f32; 6] = [0.0, 2.328_306_4e-10, 1e-4, 0.5, 0.999_9, 0.999_999_94];
/// Cosines down to where squares vanish.
const COSINES: [f32; 8] = [1.0, 0.999_999_94, 0.5, 1e-3, 1e-6, 1e-12, 1e-20, 1e-30];

fn check(name: &str, setup: &mut crate::cases::Setup, wo: Vec3f, wi: Vec3f, u: [f32; 3]) {
    let value = setup.eval(wo, wi);
    let numbers = |v: Vec3f| [v.x, v.y, v.z];
    for x in numbers(value.diffuse).into_iter().chain(numbers(value.glossy)).chain([value.pdf]) {
        assert!(x.is_finite() && x >= 0.0, "{name}: {wo:?} {wi:?} {value:?}");
    }
    let sample = setup.sample(wo, u);
    for x in numbers(sample.weight).into_iter().chain([sample.pdf]) {
        assert!(x.is_finite() && x >= 0.0, "{name}: {wo:?} {u:?} {sample:?}");
    }
    if sample.event != EVENT_ABSORB {
        let length = sample.wi.x * sample.wi.x + sample.wi.y * sample.wi.y + sample.wi.z * sample.wi.z;
        assert!((length - 1.0).abs() < 1e-5, "{name}: {wo:?} {u:?} {sample:?}");
    }
}

fn check_albedo(name: &str, setup: &mut crate::cases::Setup, wo: Vec3f) {
    let albedo = setup.albedo(wo);
    for x in [albedo.diffuse.x, albedo.diffuse.z, albedo.glossy.x, albedo.glossy.y] {
        assert!((0.0..=1.0).contains(&x), "{name}: {wo:?} {albedo:?}");
    }
    let auxiliary = setup.auxiliary(wo);
    let (n, r) = (auxiliary.normal, auxiliary.roughness);
    let length = n.x * n.x + n.y * n.y + n.z * n.z;
    let rough = (0.0..=1.000_001).contains(&r.x) && (0.0..=1.000_001).contains(&r.y);
    assert!((length - 1.0).abs() < 1e-5 && n.z >= 0.0 && rough, "{name}: {wo:?} {auxiliary:?}");
}

#[test]
fn corner_inputs_stay_finite() {
    crate::parallel(&cases(), |case| {
        let mut setup = case.setup();
        for mu_o in COSINES {
            let wo = direction(mu_o, 0.3);
            check_albedo(&case.name, &mut setup, wo);
            for mu_i in COSINES {
                // Mirrored, straight through, the same direction, and the opposite of each.
                for phi in [0.3, 0.3 + std::f32::consts::PI, 2.0] {
                    for side in [1.0, -1.0] {
                        let wi = direction(mu_i, phi);
                        let wi = vec3f(wi.x, wi.y, side * wi.z);
                        check(&case.name, &mut setup, wo, wi, [0.0, mu_i.min(0.999), 0.5]);
                    }
                }
            }
            for a in UNITS {
                for b in UNITS {
                    for c in UNITS {
                        check(&case.name, &mut setup, wo, vec3f(-wo.x, -wo.y, -wo.z), [a, b, c]);
                    }
                }
            }
        }
    });
}

#[test]
fn random_inputs_stay_finite() {
    // `LACQUER_INPUTS` asks for more in all.
    let list = cases();
    let asked = std::env::var("LACQUER_INPUTS").ok().and_then(|text| text.parse::<usize>().ok());
    let each = asked.map_or(20_000, |all| all.div_ceil(list.len()));
    crate::parallel(&list, |case| {
        let (mut setup, mut random) = (case.setup(), Random::new(99));
        for _ in 0..each {
            let wo = random.direction();
            let wo = vec3f(wo.x, wo.y, wo.z.abs());
            if wo.z > 0.0 {
                let u = [random.unit(), random.unit(), random.unit()];
                check(&case.name, &mut setup, wo, random.direction(), u);
            }
        }
    });
}

#[test]
fn bad_parameters_stay_finite() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 2.0, 1e6, f32::MAX];
    let mut list = Vec::new();
    for a in bad {
        for b in bad {
            let glossy = Tree::GgxSmith {
                tint: [a, b, 0.5],
                roughness_u: a,
                roughness_v: b,
                mode: ScatterMode::ReflectTransmit,
                tangent: Some([a, b, 0.0]),
            };
            let models = [
                GlossyModel::BeckmannSmith,
                GlossyModel::GgxVcavities,
                GlossyModel::Simple,
                GlossyModel::Ward,
                GlossyModel::Backscattering,
            ];
            let other = Tree::Glossy {
                model: models[list.len() % models.len()],
                tint: [a, b, 0.5],
                multiscatter_tint: Some([b, a, 1.0]),
                roughness_u: a,
                roughness_v: b,
                mode: ScatterMode::ReflectTransmit,
                tangent: Some([b, a, 0.0]),
            };
            let sheen = Tree::Sheen { tint: [a; 3], roughness: b };
            let glossy = layer(
                Curve::Sheen { roughness: a },
                b,
                None,
                sheen,
                layer(Curve::Constant, 0.5, None, glossy, other),
            );
            let rough =
                Tree::DiffuseReflection { tint: [b; 3], roughness: a, multiscatter_tint: Some([a; 3]) };
            let curve = Curve::Custom {
                normal_reflectivity: [a; 3],
                grazing_reflectivity: [b; 3],
                f82_factor: Some([a, b, 1.0]),
                exponent: b,
            };
            let custom = layer(curve, a, Some([a, b, 1.0]), glossy.clone(), rough.clone());
            let fresnel = layer(Curve::Fresnel { ior: a }, b, None, custom, glossy.clone());
            let color = layer(Curve::ColorFresnel { ior: [a, b, 1.5] }, 1.0, None, fresnel, rough);
            let factor = Tree::DirectionalFactor {
                normal_tint: [a; 3],
                grazing_tint: [b; 3],
                f82_factor: Some([b; 3]),
                exponent: a,
                base: Box::new(color),
            };
            let flakes = Tree::MicroflakeSheen { tint: [b; 3], roughness: a };
            let dust = Tree::DustyDiffuse { tint: [a, b, 0.5] };
            let dusty = layer(Curve::Microflake { roughness: b }, a, None, flakes, dust);
            let factor = layer(Curve::Constant, 0.7, None, factor, dusty);
            let measured = Curve::Measured { values: vec![[a; 3], [b; 3], [a, b, 0.5]] };
            let measured = layer(measured, b, Some([b, a, 1.0]), factor, Tree::Black);
            let metal = Tree::FresnelFactor { ior: [a; 3], extinction: [b; 3], base: Box::new(measured) };
            let coat = Tree::CoatAbsorption {
                ior: [b; 3],
                coefficient: [a; 3],
                thickness: b,
                base: Box::new(metal),
            };
            let filmed = Tree::ThinFilm { thickness: a, ior: [b; 3], base: Box::new(coat) };
            let tree = Tree::Tint { tint: [a; 3], transmission: Some([b; 3]), base: Box::new(filmed) };
            list.push(Case {
                name: format!("{a} and {b}"),
                tree,
                point: point(1.0, 1.5, 0),
                lossless: false,
                options: BsdfOptions::default(),
                reciprocal: false,
            });
        }
    }
    crate::parallel(&list, |case| {
        let (mut setup, mut random) = (case.setup(), Random::new(8));
        for _ in 0..2_000 {
            let wo = random.direction();
            let wo = vec3f(wo.x, wo.y, wo.z.abs().max(1e-6));
            let u = [random.unit(), random.unit(), random.unit()];
            check(&case.name, &mut setup, wo, random.direction(), u);
        }
        check_albedo(&case.name, &mut setup, direction(0.3, 0.0));
    });
}

#[test]
fn antipodal_directions_scatter_nothing_reflected() {
    // wo = −wi has no half vector.
    let mut setup = Case {
        name: String::new(),
        tree: ggx(0.5, 0.5, ScatterMode::Reflect),
        point: point(1.0, 1.5, 0),
        lossless: false,
        options: BsdfOptions::default(),
        reciprocal: true,
    }
    .setup();
    let wo = direction(0.5, 0.2);
    let value = setup.eval(wo, vec3f(-wo.x, -wo.y, -wo.z));
    assert_eq!((value.glossy.x, value.pdf), (0.0, 0.0));
}
