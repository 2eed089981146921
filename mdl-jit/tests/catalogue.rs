//! Every material of the catalogue compiles, and its inputs are the same on the interpreter's terms.

use mdl_frontend::Compiler;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::MemoryLoader;
use mdl_jit::material::{Material, Part, Runtime};
use mdl_jit::mdl::material::default_arguments;
use mdl_jit::mdl::{CompiledMaterial, InterpreterFolder};
use mdl_jit::state::{StateBatch, StateField, StateFields};
use mdl_jit::texture::NoTextures;

fn compiler() -> Compiler {
    let mut loader = MemoryLoader::new();
    for module in materials::modules() {
        loader = loader.with_root(module.name, module.text, "catalogue");
    }
    Compiler::new(loader).with_folder(InterpreterFolder)
}

/// All materials of the catalogue, compiled with their default arguments.
fn catalogue(mode: Mode) -> Vec<Material> {
    let compiler = compiler();
    let mut found = Vec::new();
    for module in materials::catalogue() {
        let checked = compiler.check(module.name).unwrap_or_else(|e| panic!("{}: {e}", module.name));
        let problems: Vec<_> = checked.diagnostics().iter().map(|d| format!("{d:?}")).collect();
        assert!(problems.is_empty(), "{}:\n{}", module.name, problems.join("\n"));
        for info in checked.materials() {
            let graph = compiler
                .material_graph(&checked, &info.name, mode, &[])
                .unwrap_or_else(|e| panic!("{}: {e}", info.qualified));
            let arguments = default_arguments(&graph);
            let compiled = CompiledMaterial::new(&graph, &arguments, Default::default())
                .unwrap_or_else(|e| panic!("{}: {e}", info.qualified));
            assert_eq!(compiled.warnings(), [] as [String; 0]);
            let material = compiled.instantiate(&arguments, &[]).expect("the arguments are the defaults");
            found.push(material.expect("the structure was decided by these arguments"));
        }
    }
    found
}

/// Points on a sphere.
fn states(fields: StateFields) -> StateBatch {
    let mut state = StateBatch::default();
    let len = 37;
    state.reset(len, fields);
    for i in 0..len {
        let (u, v) = (i as f32 / len as f32, (i * 7 % len) as f32 / len as f32);
        let (sin, cos) = (u * std::f32::consts::TAU).sin_cos();
        let z = 2.0 * v - 1.0;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let normal = [r * cos, z, r * sin];
        state.set(StateField::Position, i, normal);
        state.set(StateField::Normal, i, normal);
        state.set(StateField::GeometryNormal, i, normal);
        state.set(StateField::TextureCoordinate0, i, [u, v, 0.0]);
        state.set(StateField::TextureTangentU0, i, [-sin, 0.0, cos]);
        state.set(StateField::TextureTangentV0, i, [-z * cos, r, -z * sin]);
        state.set(StateField::FrameX, i, [-sin, 0.0, cos]);
        state.set(StateField::FrameY, i, [-z * cos, r, -z * sin]);
        state.set(StateField::FrameZ, i, normal);
        state.set(StateField::Instance, i, [f32::from_bits(0)]);
    }
    state
}

const IDENTITY: [[f32; 4]; 6] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

#[test]
fn every_material_compiles_and_its_inputs_are_finite() {
    for mode in [Mode::Class, Mode::Instance] {
        let materials = catalogue(mode);
        assert!(materials.len() >= 18, "{}", materials.len());
        for material in materials {
            for part in Part::ALL {
                let inputs = material.inputs(part);
                let state = states(inputs.state);
                let runtime = Runtime {
                    textures: &NoTextures,
                    transforms: &IDENTITY,
                    animation_time: 0.0,
                    meters_per_unit: 1.0,
                };
                let mut columns = Vec::new();
                inputs.run(&state, &runtime, &mut columns).unwrap_or_else(|e| panic!("{e}"));
                for output in 0..inputs.uniform.len() {
                    for point in 0..state.len() {
                        let x = inputs.value(&columns, output, point);
                        assert!(x.is_finite(), "{} {part:?} output {output}: {x}", material.name);
                    }
                }
            }
        }
    }
}

/// Class and instance mode are the same material.
#[test]
fn modes_agree() {
    for (class, instance) in catalogue(Mode::Class).iter().zip(catalogue(Mode::Instance)) {
        for part in Part::ALL {
            let run = |material: &Material| {
                let inputs = material.inputs(part);
                let state = states(inputs.state);
                let runtime = Runtime {
                    textures: &NoTextures,
                    transforms: &IDENTITY,
                    animation_time: 0.0,
                    meters_per_unit: 1.0,
                };
                let mut columns = Vec::new();
                inputs.run(&state, &runtime, &mut columns).unwrap_or_else(|e| panic!("{e}"));
                let value = |output| (0..37).map(|p| inputs.value(&columns, output, p)).collect::<Vec<_>>();
                (0..inputs.uniform.len()).map(value).collect::<Vec<_>>()
            };
            let (a, b) = (run(class), run(&instance));
            // Folding may drop nodes and so slots; what both have must agree.
            if a.len() == b.len() {
                for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                    assert!((a - b).abs() <= 1e-5 * (1.0 + a.abs()), "{} {part:?}: {a} {b}", class.name);
                }
            }
        }
    }
}
