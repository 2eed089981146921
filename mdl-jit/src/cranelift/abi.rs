//! What compiled code finds in memory: the context, an array of 64-bit words.
//!
//! Compiled code has the signature `fn(context, begin, end) -> fault`: it computes the points whose
//! columns lie between two byte offsets. The context holds, in order: a word for the offset of the group
//! at fault, the table of host functions, the kernel's constant tables, and what [`Abi`] numbers below. A column is a pointer and a
//! mask for the byte offset: all ones for a column, zero for sixteen bytes that serve every group.

use crate::batch::{ArgMode, Interface, Mode};

/// Word of the offset at fault.
pub const FAULT: usize = 0;
/// Word of the pointer to the host functions.
pub const HOST: usize = 1;
/// Word of the pointer to the kernel's constant tables.
pub const CONSTANTS: usize = 2;

/// Where an argument is.
#[derive(Clone, Debug)]
pub enum ArgWords {
    /// Per leaf: a word with the bits of a uniform value, or a pointer to a column.
    Leaves(Vec<(usize, Mode)>),
    /// A pointer to the words of a uniform table.
    Words(usize),
    /// A pointer to the columns of a table.
    Columns(usize),
}

/// The numbers of the words of the context.
#[derive(Clone, Debug)]
pub struct Abi {
    /// Per argument.
    pub args: Vec<ArgWords>,
    /// The first of the columns of the outputs, two words each.
    pub outputs: usize,
    /// The first of the buffers, two words each: pointer and bytes.
    pub buffers: usize,
    /// Number of words.
    pub len: usize,
}

impl Abi {
    pub fn new(interface: &Interface, buffers: usize) -> Self {
        let mut len = 3;
        let mut take = |n: usize| {
            len += n;
            len - n
        };
        let args = interface
            .args
            .iter()
            .map(|arg| match arg.mode {
                ArgMode::Table(Mode::Uniform) => ArgWords::Words(take(1)),
                ArgMode::Table(Mode::Varying) => ArgWords::Columns(take(1)),
                _ => ArgWords::Leaves((0..arg.kinds.len()).map(|i| (take(1), arg.leaf_mode(i))).collect()),
            })
            .collect();
        let outputs = take(2 * interface.outputs.len());
        let buffers = take(2 * buffers);
        Self { args, outputs, buffers, len }
    }
}
