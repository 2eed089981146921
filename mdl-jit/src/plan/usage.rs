//! How local variables are used: which need memory, and which need their initial value.

use naga::{Block, Statement};

use super::{Index, Local, Node};

/// The variable that a pointer is derived from.
fn root(nodes: &[Node], pointer: usize) -> Option<usize> {
    match nodes[pointer] {
        Node::Local(i) => Some(i as usize),
        Node::Part { base, place: true, .. } | Node::Member { base, place: true, .. } => root(nodes, base),
        _ => None,
    }
}

/// Fills in `indexed` and `starts` of all locals.
pub fn locals(nodes: &[Node], body: &Block, locals: &mut [Local]) {
    for node in nodes {
        if let Node::Part { base, index: Index::Computed(_), ref parts, place: true } = *node
            && parts.classes == 0
            && let Some(i) = root(nodes, base)
        {
            locals[i].indexed = true;
        }
    }
    let mut walk = Walk { nodes, locals, assigned: Vec::new() };
    walk.block(body);
}

/// Visits statements in the order of the text. A variable counts as assigned after a store to all of it
/// until the end of the block with that store.
struct Walk<'a> {
    nodes: &'a [Node],
    locals: &'a mut [Local],
    assigned: Vec<usize>,
}

impl Walk<'_> {
    fn block(&mut self, block: &Block) {
        let depth = self.assigned.len();
        for statement in block.iter() {
            self.statement(statement);
        }
        self.assigned.truncate(depth);
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Emit(range) => {
                for i in range.index_range() {
                    if let Node::Load(pointer) = self.nodes[i as usize] {
                        self.used(pointer);
                    }
                }
            }
            Statement::Store { pointer, .. } => match self.nodes[pointer.index()] {
                Node::Local(i) => self.assigned.push(i as usize),
                _ => self.used(pointer.index()),
            },
            Statement::Call { arguments, .. } => {
                for a in arguments {
                    if let Some(i) = root(self.nodes, a.index()) {
                        // The callee may index it in any way.
                        self.locals[i].indexed = true;
                        self.used(a.index());
                    }
                }
            }
            Statement::Block(b) => self.block(b),
            Statement::If { accept, reject, .. } => {
                self.block(accept);
                self.block(reject);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|c| self.block(&c.body)),
            Statement::Loop { body, continuing, .. } => {
                self.block(body);
                self.block(continuing);
            }
            _ => {}
        }
    }

    fn used(&mut self, pointer: usize) {
        if let Some(i) = root(self.nodes, pointer)
            && !self.assigned.contains(&i)
        {
            self.locals[i].starts = true;
        }
    }
}
