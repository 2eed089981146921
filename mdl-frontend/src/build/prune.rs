//! Drops what nothing uses, and renumbers the rest.

use crate::graph::{
    Expression, ExpressionId, ExpressionKind, Function, FunctionId, Graph, Node, NodeId, NodeKind, Op,
    Parameter, Place, Projection, Statement,
};
use crate::value::Value;

/// Drops expressions of a function that no statement uses.
pub fn expressions(mut function: Function) -> Function {
    let mut used = vec![false; function.expressions.len()];
    each_statement_use(&function.body, &mut |id| used[id.0 as usize] = true);
    // Operands stand before their users.
    for index in (0..function.expressions.len()).rev() {
        if used[index] {
            each_operand(&function.expressions[index], |id| used[id.0 as usize] = true);
        }
    }
    let numbers = numbers(&used);
    let renumber = |id: &mut ExpressionId| id.0 = numbers[id.0 as usize];
    let mut used = used.into_iter();
    function.expressions.retain(|_| used.next().unwrap_or(false));
    for expression in &mut function.expressions {
        match &mut expression.kind {
            ExpressionKind::Constant(_) => {}
            ExpressionKind::Read(place) => place_uses(place).for_each(renumber),
            ExpressionKind::Op(_, args) => args.iter_mut().for_each(renumber),
        }
    }
    renumber_statements(&mut function.body, &renumber);
    function
}

/// New numbers of what is used.
fn numbers(used: &[bool]) -> Vec<u32> {
    let mut next = 0;
    let number = |used: &bool| {
        next += u32::from(*used);
        next.wrapping_sub(1)
    };
    used.iter().map(number).collect()
}

fn place_uses(place: &mut Place) -> impl Iterator<Item = &mut ExpressionId> {
    place.path.iter_mut().filter_map(|projection| match projection {
        Projection::Index(id) => Some(id),
        Projection::Member(_) => None,
    })
}

fn each_operand(expression: &Expression, mut visit: impl FnMut(ExpressionId)) {
    match &expression.kind {
        ExpressionKind::Constant(_) => {}
        ExpressionKind::Read(place) => each_place_use(place, &mut visit),
        ExpressionKind::Op(_, args) => args.iter().copied().for_each(visit),
    }
}

fn each_place_use(place: &Place, visit: &mut impl FnMut(ExpressionId)) {
    for projection in &place.path {
        if let Projection::Index(id) = projection {
            visit(*id);
        }
    }
}

/// Calls `visit` with the expressions that statements use. Statements are nested a few levels deep only.
fn each_statement_use(statements: &[Statement], visit: &mut dyn FnMut(ExpressionId)) {
    for statement in statements {
        match statement {
            Statement::Evaluate(id) | Statement::Return(id) => visit(*id),
            Statement::Store { place, value } => {
                each_place_use(place, &mut |id| visit(id));
                visit(*value);
            }
            Statement::If { condition, then, otherwise } => {
                visit(*condition);
                each_statement_use(then, visit);
                each_statement_use(otherwise, visit);
            }
            Statement::Switch { selector, cases } => {
                visit(*selector);
                cases.iter().for_each(|case| each_statement_use(&case.body, visit));
            }
            Statement::Loop { body, continuing, .. } => {
                each_statement_use(body, visit);
                each_statement_use(continuing, visit);
            }
            Statement::Break | Statement::Continue => {}
        }
    }
}

fn renumber_statements(statements: &mut [Statement], renumber: &dyn Fn(&mut ExpressionId)) {
    for statement in statements {
        match statement {
            Statement::Evaluate(id) | Statement::Return(id) => renumber(id),
            Statement::Store { place, value } => {
                place_uses(place).for_each(renumber);
                renumber(value);
            }
            Statement::If { condition, then, otherwise } => {
                renumber(condition);
                renumber_statements(then, renumber);
                renumber_statements(otherwise, renumber);
            }
            Statement::Switch { selector, cases } => {
                renumber(selector);
                cases.iter_mut().for_each(|case| renumber_statements(&mut case.body, renumber));
            }
            Statement::Loop { body, continuing, .. } => {
                renumber_statements(body, renumber);
                renumber_statements(continuing, renumber);
            }
            Statement::Break | Statement::Continue => {}
        }
    }
}

/// Drops nodes, functions and resources that the roots do not need, and renumbers the roots.
pub fn graph(graph: &mut Graph, roots: &mut [&mut NodeId]) {
    let nodes = live_nodes(graph, roots);
    let functions = live_functions(graph, &nodes);
    let (node_numbers, function_numbers) = (numbers(&nodes), numbers(&functions));
    retain(&mut graph.nodes, &nodes);
    retain(&mut graph.functions, &functions);
    let call = |op: &mut Op| {
        if let Op::Call(id) = op {
            id.0 = function_numbers[id.0 as usize];
        }
    };
    for Node { kind, .. } in &mut graph.nodes {
        if let NodeKind::Op(op, args) = kind {
            call(op);
            args.iter_mut().for_each(|arg| arg.0 = node_numbers[arg.0 as usize]);
        }
    }
    for expression in graph.functions.iter_mut().flat_map(|function| &mut function.expressions) {
        if let ExpressionKind::Op(op, _) = &mut expression.kind {
            call(op);
        }
    }
    roots.iter_mut().for_each(|root| root.0 = node_numbers[root.0 as usize]);
    resources(graph);
}

fn retain<T>(items: &mut Vec<T>, live: &[bool]) {
    let mut live = live.iter();
    items.retain(|_| live.next().copied().unwrap_or(false));
}

fn live_nodes(graph: &Graph, roots: &[&mut NodeId]) -> Vec<bool> {
    let mut live = vec![false; graph.nodes.len()];
    roots.iter().for_each(|root| live[root.0 as usize] = true);
    for index in (0..graph.nodes.len()).rev() {
        if let (true, NodeKind::Op(_, args)) = (live[index], &graph.nodes[index].kind) {
            args.iter().for_each(|arg| live[arg.0 as usize] = true);
        }
    }
    live
}

fn live_functions(graph: &Graph, nodes: &[bool]) -> Vec<bool> {
    let mut live = vec![false; graph.functions.len()];
    let mut mark = |op: &Op| {
        if let Op::Call(FunctionId(id)) = op {
            live[*id as usize] = true;
        }
    };
    for (node, _) in graph.nodes.iter().zip(nodes).filter(|(_, live)| **live) {
        if let NodeKind::Op(op, _) = &node.kind {
            mark(op);
        }
    }
    // Callees stand before their callers.
    for index in (0..graph.functions.len()).rev() {
        if !live[index] {
            continue;
        }
        for expression in &graph.functions[index].expressions {
            if let ExpressionKind::Op(Op::Call(FunctionId(id)), _) = expression.kind {
                live[id as usize] = true;
            }
        }
    }
    live
}

/// Drops resources that no constant refers to.
fn resources(graph: &mut Graph) {
    let mut live = vec![false; graph.resources.len()];
    each_constant(graph, &mut |value| mark_resources(value, &mut live));
    let numbers = numbers(&live);
    retain(&mut graph.resources, &live);
    each_constant(graph, &mut |value| renumber_resources(value, &numbers));
}

fn each_constant(graph: &mut Graph, visit: &mut dyn FnMut(&mut Value)) {
    for node in &mut graph.nodes {
        if let NodeKind::Constant(value) = &mut node.kind {
            visit(value);
        }
    }
    for expression in graph.functions.iter_mut().flat_map(|function| &mut function.expressions) {
        if let ExpressionKind::Constant(value) = &mut expression.kind {
            visit(value);
        }
    }
    for Parameter { default, .. } in &mut graph.parameters {
        default.iter_mut().for_each(&mut *visit);
    }
}

fn mark_resources(value: &Value, live: &mut [bool]) {
    match value {
        Value::Resource(Some(index)) => live[*index as usize] = true,
        Value::Compound(parts) => parts.iter().for_each(|part| mark_resources(part, live)),
        _ => {}
    }
}

fn renumber_resources(value: &mut Value, numbers: &[u32]) {
    match value {
        Value::Resource(Some(index)) => *index = numbers[*index as usize],
        Value::Compound(parts) if has_resource(parts) => {
            let renumbered = parts.iter().cloned().map(|mut part| {
                renumber_resources(&mut part, numbers);
                part
            });
            *value = renumbered.collect();
        }
        _ => {}
    }
}

fn has_resource(parts: &[Value]) -> bool {
    parts.iter().any(|part| match part {
        Value::Resource(index) => index.is_some(),
        Value::Compound(parts) => has_resource(parts),
        _ => false,
    })
}
