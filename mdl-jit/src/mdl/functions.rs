//! Functions with a block body as naga functions.
//!
//! Statements map one to one: naga's `Loop` has the same `continuing` part, its `Switch` the same
//! fall-through. A store to a place outside the bounds of an array is dropped by a condition around it.

use super::builder::{FunctionBuilder, Value};
use super::error::LowerError;
use super::needs::Needs;
use super::types::TypeMap;
use super::values::{LoweredFunction, Lowering, Strings};
use mdl_frontend::graph::{
    ExpressionId, ExpressionKind, Function, FunctionId, Graph, Place, Projection, Statement, SwitchCase,
};
use mdl_frontend::types::{Type, TypeId};
use naga::{BinaryOperator, Expression, ScalarKind, SwitchValue};

/// Lowers the functions that `wanted` names and all they call.
pub fn lower_functions(
    module: &mut naga::Module,
    graph: &Graph,
    map: &mut TypeMap,
    strings: &mut Strings,
    wanted: &[bool],
    needs: &Needs,
) -> Result<Vec<LoweredFunction>, LowerError> {
    let mut lowered: Vec<LoweredFunction> = Vec::new();
    let reads = Needs::of_functions(graph);
    for (index, function) in graph.functions.iter().enumerate() {
        let takes_state = reads[index];
        let handle = if wanted[index] {
            let b = FunctionBuilder::new(module, &mangled(function, index));
            let lowering =
                Lowering { b, graph, map, functions: &lowered, strings, state: None, needs: needs.clone() };
            Some(Body::lower(lowering, function, takes_state)?)
        } else {
            None
        };
        lowered.push(LoweredFunction { handle, takes_state });
    }
    Ok(lowered)
}

/// A name that is unique in the module and that every target language takes.
fn mangled(function: &Function, index: usize) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = function.name.trim_start_matches(':').chars().map(plain).collect();
    format!("mdl_{name}_{index}")
}

/// Which functions the roots of a graph call, directly or not.
pub fn called(graph: &Graph, direct: impl IntoIterator<Item = FunctionId>) -> Vec<bool> {
    let mut wanted = vec![false; graph.functions.len()];
    for id in direct {
        wanted[id.0 as usize] = true;
    }
    // Callees come before callers, so one pass from the end finds all.
    for index in (0..graph.functions.len()).rev() {
        if !wanted[index] {
            continue;
        }
        for expression in &graph.functions[index].expressions {
            if let ExpressionKind::Op(mdl_frontend::graph::Op::Call(callee), _) = expression.kind {
                wanted[callee.0 as usize] = true;
            }
        }
    }
    wanted
}

/// A body under construction.
struct Body<'m, 'g> {
    lowering: Lowering<'m, 'g>,
    function: &'g Function,
    /// Pointers to the locals.
    locals: Vec<Value>,
    /// Values of expressions, and the nesting of blocks at which they can be used.
    values: Vec<Option<Value>>,
    /// Expressions evaluated in each open block, to be forgotten when it closes.
    open: Vec<Vec<usize>>,
}

impl<'m, 'g> Body<'m, 'g> {
    fn lower(
        mut lowering: Lowering<'m, 'g>,
        function: &'g Function,
        takes_state: bool,
    ) -> Result<naga::Handle<naga::Function>, LowerError> {
        let mut arguments = Vec::new();
        for local in &function.locals[..function.parameters as usize] {
            let ty = lowering.ty(local.ty)?;
            arguments.push(lowering.b.argument(&local.name, ty));
        }
        if takes_state {
            let ty = lowering.needs.state_type(lowering.b.module)?;
            lowering.state = Some(lowering.b.argument("state", ty));
        }
        let mut locals = Vec::new();
        for (index, local) in function.locals.iter().enumerate() {
            let ty = lowering.ty(local.ty)?;
            let pointer = lowering.b.local(&local.name, ty);
            if let Some(&argument) = arguments.get(index) {
                lowering.b.store(pointer, argument);
            }
            locals.push(pointer);
        }
        let values = vec![None; function.expressions.len()];
        let mut body = Self { lowering, function, locals, values, open: vec![Vec::new()] };
        body.statements(&function.body)?;
        let result = body.lowering.ty(function.result)?;
        // Every path returns, which naga does not see behind an endless loop.
        if !matches!(function.body.last(), Some(Statement::Return(_))) {
            let zero = body.lowering.b.zero(result);
            body.lowering.b.statement(naga::Statement::Return { value: Some(zero) });
        }
        Ok(body.lowering.b.finish(result))
    }

    fn statements(&mut self, statements: &[Statement]) -> Result<(), LowerError> {
        for statement in statements {
            self.statement(statement)?;
            // What follows a jump is never reached, and naga does not allow it.
            if matches!(statement, Statement::Break | Statement::Continue | Statement::Return(_)) {
                break;
            }
        }
        Ok(())
    }

    /// Statements in a block of their own.
    fn block(&mut self, statements: &[Statement]) -> Result<naga::Block, LowerError> {
        self.lowering.b.open();
        self.open.push(Vec::new());
        self.statements(statements)?;
        for index in self.open.pop().expect("pushed above") {
            self.values[index] = None;
        }
        Ok(self.lowering.b.close())
    }

    fn statement(&mut self, statement: &Statement) -> Result<(), LowerError> {
        match statement {
            Statement::Evaluate(expression) => {
                self.value(*expression)?;
            }
            Statement::Store { place, value } => self.store(place, *value)?,
            Statement::If { condition, then, otherwise } => {
                let condition = self.value(*condition)?;
                let accept = self.block(then)?;
                let reject = self.block(otherwise)?;
                self.lowering.b.statement(naga::Statement::If { condition, accept, reject });
            }
            Statement::Switch { selector, cases } => self.switch(*selector, cases)?,
            Statement::Loop { body, continuing, .. } => {
                let body = self.block(body)?;
                let continuing = self.block(continuing)?;
                self.lowering.b.statement(naga::Statement::Loop { body, continuing, break_if: None });
            }
            Statement::Break => self.lowering.b.statement(naga::Statement::Break),
            Statement::Continue => self.lowering.b.statement(naga::Statement::Continue),
            Statement::Return(value) => {
                let value = Some(self.value(*value)?);
                self.lowering.b.statement(naga::Statement::Return { value });
            }
        }
        Ok(())
    }

    /// Labels of one case become cases that fall through to the last of them; without a `default` one
    /// that does nothing is added, which naga asks for.
    fn switch(&mut self, selector: ExpressionId, cases: &[SwitchCase]) -> Result<(), LowerError> {
        let selector = self.value(selector)?;
        let mut lowered = Vec::new();
        for case in cases {
            let mut body = self.block(&case.body)?;
            let last = case.labels.len().saturating_sub(1);
            for (index, label) in case.labels.iter().enumerate() {
                let value = label.map_or(SwitchValue::Default, SwitchValue::I32);
                let (body, fall_through) = match index == last {
                    true => (std::mem::take(&mut body), case.falls_through),
                    false => (naga::Block::new(), true),
                };
                lowered.push(naga::SwitchCase { value, body, fall_through });
            }
        }
        if !cases.iter().any(|case| case.labels.contains(&None)) {
            let body = naga::Block::new();
            lowered.push(naga::SwitchCase { value: SwitchValue::Default, body, fall_through: false });
        }
        // The last case has nothing to fall into.
        if let Some(last) = lowered.last_mut() {
            last.fall_through = false;
        }
        self.lowering.b.statement(naga::Statement::Switch { selector, cases: lowered });
        Ok(())
    }

    fn value(&mut self, id: ExpressionId) -> Result<Value, LowerError> {
        let index = id.0 as usize;
        if let Some(value) = self.values[index] {
            return Ok(value);
        }
        let function = self.function;
        let expression = &function.expressions[index];
        let value = match &expression.kind {
            ExpressionKind::Constant(value) => self.lowering.constant(value, expression.ty)?,
            ExpressionKind::Read(place) => self.read(place)?,
            ExpressionKind::Op(op, args) => {
                let mut values = Vec::with_capacity(args.len());
                for arg in args {
                    values.push((self.value(*arg)?, function.expressions[arg.0 as usize].ty));
                }
                self.lowering.op(op, &values, expression.ty)?
            }
        };
        self.values[index] = Some(value);
        self.open.last_mut().expect("the body is a block").push(index);
        Ok(value)
    }

    /// A pointer to a place, whether it lies within all bounds, and its type. The pointer itself is
    /// always within bounds.
    fn pointer(&mut self, place: &Place) -> Result<(Value, Option<Value>, PlaceType), LowerError> {
        let mut pointer = self.locals[place.local.0 as usize];
        let mut ty = PlaceType::Known(self.function.locals[place.local.0 as usize].ty);
        let mut inside: Option<Value> = None;
        for projection in &place.path {
            let (size, parts) = self.parts(ty);
            match projection {
                Projection::Member(index) => {
                    pointer = self.lowering.b.part(pointer, *index);
                    ty = parts(*index);
                }
                Projection::Index(index) => {
                    let index = self.value(*index)?;
                    let b = &mut self.lowering.b;
                    let unsigned = b.bitcast(index, ScalarKind::Uint);
                    let (limit, last) = (b.u32(size), b.u32(size.max(1) - 1));
                    let within = b.binary(BinaryOperator::Less, unsigned, limit);
                    inside = Some(match inside {
                        Some(inside) => b.binary(BinaryOperator::LogicalAnd, inside, within),
                        None => within,
                    });
                    let limited = b.math(naga::MathFunction::Min, &[unsigned, last]);
                    pointer = b.append(Expression::Access { base: pointer, index: limited });
                    ty = parts(0);
                }
            }
        }
        Ok((pointer, inside, ty))
    }

    /// Number of parts of a type, and the type of each.
    fn parts(&self, ty: PlaceType) -> (u32, impl Fn(u32) -> PlaceType + use<'m, 'g>) {
        let types = &self.lowering.graph.types;
        let (size, fields): (u32, Vec<PlaceType>) = match ty {
            PlaceType::Column(rows) => (u32::from(rows), vec![PlaceType::Known(TypeId::FLOAT)]),
            PlaceType::Known(ty) => match types.get(ty) {
                Type::Struct(ty) => {
                    (0, ty.fields.iter().map(|(_, field)| PlaceType::Known(*field)).collect())
                }
                Type::Array { element, size } => (*size, vec![PlaceType::Known(*element)]),
                Type::Matrix { columns, rows, .. } => (u32::from(*columns), vec![PlaceType::Column(*rows)]),
                Type::Vector { scalar, size } => {
                    use mdl_frontend::types::Scalar;
                    let element = match scalar {
                        Scalar::Bool => TypeId::BOOL,
                        Scalar::Int => TypeId::INT,
                        Scalar::Float => TypeId::FLOAT,
                        Scalar::Double => TypeId::DOUBLE,
                    };
                    (u32::from(*size), vec![PlaceType::Known(element)])
                }
                _ => (3, vec![PlaceType::Known(TypeId::FLOAT)]),
            },
        };
        (size, move |index| *fields.get(index as usize).unwrap_or(&fields[0]))
    }

    fn read(&mut self, place: &Place) -> Result<Value, LowerError> {
        let (pointer, inside, ty) = self.pointer(place)?;
        let value = self.lowering.b.load(pointer);
        let Some(inside) = inside else { return Ok(value) };
        match ty {
            PlaceType::Known(ty) => {
                let handle = self.lowering.ty(ty)?;
                let zero = self.lowering.b.zero(handle);
                self.lowering.select(inside, value, zero, ty)
            }
            PlaceType::Column(rows) => {
                let handle = self.lowering.b.float_type(rows);
                let zero = self.lowering.b.zero(handle);
                Ok(self.lowering.b.select(inside, value, zero))
            }
        }
    }

    fn store(&mut self, place: &Place, value: ExpressionId) -> Result<(), LowerError> {
        let value = self.value(value)?;
        let (pointer, inside, _) = self.pointer(place)?;
        let Some(condition) = inside else {
            self.lowering.b.store(pointer, value);
            return Ok(());
        };
        self.lowering.b.open();
        self.lowering.b.store(pointer, value);
        let accept = self.lowering.b.close();
        self.lowering.b.statement(naga::Statement::If { condition, accept, reject: naga::Block::new() });
        Ok(())
    }
}

/// The type of a place: columns of matrices have no entry in the table of types.
#[derive(Clone, Copy)]
enum PlaceType {
    Known(TypeId),
    Column(u8),
}
