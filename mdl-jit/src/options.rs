//! How functions are compiled.

/// How many points one pass of compiled code computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lanes {
    /// One: for code whose points go different ways.
    One,
    /// Four, under a mask where they diverge.
    Four,
    /// Twice four side by side where the code has loops, which wait for their own results; else four.
    #[default]
    Eight,
}

/// How much work the code generator puts into the code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tier {
    /// A single pass of register allocation, no optimisation: first code soon.
    Fast,
    /// Good register allocation, no optimisation: nearly as good unless much is uniform.
    Plain,
    /// Optimised code.
    #[default]
    Optimised,
}

/// Which instructions may be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Target {
    /// Those of the machine, found at run time.
    #[default]
    Host,
    /// x86-64 with SSE4.1 and no more; on other machines the same as `Host`.
    Sse41,
    /// The least of the architecture: SSE2 on x86-64.
    Baseline,
}

/// How functions are compiled and run.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Options {
    /// Names of functions that the host supplies at each run, instead of their bodies.
    pub externs: Vec<String>,
    /// Whether calls to the texture functions are answered by the textures of each batch.
    pub textures: bool,
    /// Loop iterations and calls per point after which a run ends with a fault. Compiled code counts
    /// the iterations of a group of lanes together and does not count calls.
    pub steps: u32,
    /// Points per pass.
    pub lanes: Lanes,
    /// Effort.
    pub tier: Tier,
    /// Instruction set.
    pub target: Target,
    /// Runs the code generator's verifier; meant for tests.
    pub verify: bool,
    /// Expressions after inlining beyond which compilation is refused.
    pub max_expressions: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            externs: Vec::new(),
            textures: true,
            steps: 1 << 20,
            lanes: Lanes::default(),
            tier: Tier::default(),
            target: Target::default(),
            verify: cfg!(debug_assertions),
            max_expressions: 200_000,
        }
    }
}

impl Options {
    /// Whether calls to `name` go to the host.
    pub(crate) fn replaces(&self, name: &str) -> bool {
        let texture = self.textures && crate::externs::TEXTURE_FUNCTIONS.contains(&name);
        texture || self.externs.iter().any(|e| e == name)
    }
}
