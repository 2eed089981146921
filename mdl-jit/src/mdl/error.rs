//! Why a graph cannot be compiled.

/// A construct that the executors do not carry, or a limit that was exceeded. The front end has checked
/// everything else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LowerError {
    /// A function of a standard module that has no implementation yet.
    #[error("`{0}` is not supported yet")]
    Builtin(String),
    /// A type that has no representation yet.
    #[error("values of type `{0}` are not supported yet where they are computed per shading point")]
    Type(String),
    /// A function that gives no colour is asked for the light of an environment.
    #[error("an environment is a function that gives a `color`, not `{0}`")]
    Environment(String),
    /// A conversion between types that has no implementation yet.
    #[error("a conversion from `{from}` to `{to}` is not supported yet")]
    Conversion {
        /// Type of the operand.
        from: String,
        /// Type of the result.
        to: String,
    },
    /// A distribution function that the evaluator does not carry yet, or a parameter of one.
    #[error("{0} is not supported yet")]
    Distribution(String),
    /// A tree of distribution functions is too large.
    #[error(transparent)]
    Program(#[from] layered_bsdf::program::ProgramError),
    /// A tree of distribution functions is nested too deeply.
    #[error("distribution functions are nested more than {0} levels deep")]
    TooDeep(usize),
    /// The generated code did not validate: an error of this compiler.
    #[error("internal error: generated code is not valid: {0}")]
    Invalid(String),
    /// The structure of a material depends on what is known only when something is rendered.
    #[error(
        "the structure depends on a texture, a transform, the number of the object or the unit of the scene, \
         which is not supported"
    )]
    Structure,
    /// A uniform value could not be computed.
    #[error("a value that depends on arguments alone could not be computed: {0}")]
    Uniform(String),
}
