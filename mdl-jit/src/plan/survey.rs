//! What statements do: calls, nesting, and what no executor runs.

use naga::{Block, Function, Handle, Statement};

use super::Plan;
use crate::error::{CompileError, Unsupported};

/// Blocks nested deeper than this, those of called functions included, are refused, so that executors
/// may recurse.
const MAX_DEPTH: usize = 200;

/// The blocks in a statement.
pub fn inner(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(b) => vec![b],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|c| &c.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// The blocks in a statement, to change.
pub fn inner_mut(statement: &mut Statement) -> Vec<&mut Block> {
    match statement {
        Statement::Block(b) => vec![b],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter_mut().map(|c| &mut c.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// Appends the functions called in `block`.
pub fn called(block: &Block, out: &mut Vec<Handle<Function>>) {
    for statement in block.iter() {
        if let Statement::Call { function, .. } = statement {
            out.push(*function);
        }
        inner(statement).into_iter().for_each(|b| called(b, out));
    }
}

/// Refuses functions with statements that no executor runs.
pub fn check(
    module: &naga::Module,
    info: &naga::valid::FunctionInfo,
    body: &Block,
) -> Result<(), Unsupported> {
    if nesting(body, 0, &|_| 0) > MAX_DEPTH {
        return Err(Unsupported::Depth);
    }
    check_block(module, info, body)
}

fn check_block(
    module: &naga::Module,
    info: &naga::valid::FunctionInfo,
    block: &Block,
) -> Result<(), Unsupported> {
    for statement in block.iter() {
        match statement {
            Statement::Store { pointer, .. } => {
                use naga::AddressSpace as S;
                let space = info[*pointer].ty.inner_with(&module.types).pointer_space();
                if !matches!(space, Some(S::Function | S::Private)) {
                    return Err(Unsupported::Store("a buffer"));
                }
            }
            Statement::Emit(_) | Statement::Call { .. } | Statement::Return { .. } => {}
            Statement::Break | Statement::Continue => {}
            Statement::Block(_)
            | Statement::If { .. }
            | Statement::Switch { .. }
            | Statement::Loop { .. } => {
                for b in inner(statement) {
                    check_block(module, info, b)?;
                }
            }
            other => return Err(Unsupported::Statement(variant(other))),
        }
    }
    Ok(())
}

/// Refuses functions whose blocks, through calls, nest too deeply. Calls go to functions that stand
/// earlier in the arena, so one pass in order is enough.
pub fn check_depth(plan: &Plan<'_>) -> Result<(), CompileError> {
    let mut depths = vec![0usize; plan.functions.len()];
    for (handle, f) in plan.module.functions.iter() {
        let Some(function) = plan.functions[handle.index()].as_ref().filter(|f| !f.replaced) else {
            continue;
        };
        let depth = nesting(&f.body, 0, &|callee| depths[callee.index()]);
        depths[handle.index()] = depth;
        if depth > MAX_DEPTH {
            let function = function.name.clone();
            return Err(CompileError::Unsupported { function, cause: Unsupported::Depth });
        }
    }
    Ok(())
}

/// The depth of the deepest block in one at depth `at`, where a call adds the depth of its callee.
/// Stops counting when it is too much.
fn nesting(block: &Block, at: usize, callee: &dyn Fn(Handle<Function>) -> usize) -> usize {
    if at > MAX_DEPTH {
        return at;
    }
    let of = |statement: &Statement| match statement {
        Statement::Call { function, .. } => at + 1 + callee(*function),
        _ => inner(statement).into_iter().map(|b| nesting(b, at + 1, callee)).max().unwrap_or(at),
    };
    block.iter().map(of).max().unwrap_or(at)
}

/// The name of an enum's variant.
pub fn variant(value: &impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    text.split([' ', '(', '{']).next().unwrap_or_default().to_owned()
}
