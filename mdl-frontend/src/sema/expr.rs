//! Expressions.

use super::Checker;
use super::convert::{self};
use super::hir::{Entity, ExprId, ExprKind, Local};
use super::lookup::Found;
use super::operators;
use super::scope::LocalEntry;
use super::ty::{Base, Size, Ty};
use super::type_expr::TypeUse;
use crate::diagnostics::{flow as flow_problems, names as name_problems, types as problems};
use crate::fold;
use crate::graph::{BinaryOp, UnaryOp};
use crate::span::Span;
use crate::syntax::ast::{self, FloatLiteral, FloatSuffix, Init, Step};
use crate::value::Value;

impl<'a> Checker<'_, 'a> {
    /// Checks an expression.
    pub(super) fn expr(&mut self, id: ast::ExprId) -> ExprId {
        use ast::ExprKind as E;
        let nodes = self.nodes;
        let ast::Expr { kind, span } = nodes.expr(id);
        let span = *span;
        match kind {
            E::Error => self.error(span),
            E::Bool(value) => self.constant(Value::Bool(*value), Ty::BOOL, span),
            E::Int(value) => self.constant(Value::Int(*value), Ty::INT, span),
            E::Float(literal) => self.float(*literal, span),
            E::String(text) => self.constant(Value::String(text.clone()), Ty::STRING, span),
            E::IntensityMode(value) => self.constant(Value::Int((*value).into()), Ty::INTENSITY_MODE, span),
            E::Name(path) => self.name(*path),
            E::Type(_) | E::ArrayType(..) => {
                let name = self.slice(span).to_string();
                self.emit(span, name_problems::NotAValue { name, what: "a type" });
                self.error(span)
            }
            E::Paren(x) => self.expr(*x),
            E::Member(x, member) => {
                let x = self.expr(*x);
                self.member(x, *member, span)
            }
            E::Index(x, index) => {
                let (x, index) = (self.expr(*x), self.expr(*index));
                self.index(x, index, span)
            }
            E::Call(callee, args) => self.call(*callee, args, span),
            E::Unary(op, x) => {
                let x = self.expr(*x);
                self.unary(*op, x, span)
            }
            E::Step(step, x) => self.step(*step, *x, span),
            E::Binary(op, x, y) => {
                let (x, y) = (self.expr(*x), self.expr(*y));
                self.binary(*op, x, y, span)
            }
            E::Assign(op, x, y) => self.assign(*op, *x, *y, span),
            E::Sequence(x, y) => {
                self.require_imperative(span);
                let (x, y) = (self.expr(*x), self.expr(*y));
                let ty = self.body.ty(y);
                self.push(ExprKind::Sequence(x, y), ty, span)
            }
            E::Ternary(condition, x, y) => {
                let condition = self.condition(*condition);
                let (x, y) = (self.expr(*x), self.expr(*y));
                self.select(condition, x, y, span)
            }
            E::Let(decls, body) => self.let_in(decls, *body, span),
            E::Cast(ty, x) => self.cast(ty, *x, span),
            E::Operator(op, args) => self.operator_call(*op, args, span),
        }
    }

    pub(super) fn push(&mut self, kind: ExprKind, ty: Ty, span: Span) -> ExprId {
        self.body.push(kind, ty, span)
    }

    /// An expression that could not be understood; reported.
    pub(super) fn error(&mut self, span: Span) -> ExprId {
        self.push(ExprKind::Error, Ty::ERROR, span)
    }

    pub(super) fn constant(&mut self, value: Value, ty: Ty, span: Span) -> ExprId {
        self.push(ExprKind::Constant(value), ty, span)
    }

    fn float(&mut self, literal: FloatLiteral, span: Span) -> ExprId {
        let FloatLiteral { value, suffix } = literal;
        if suffix == FloatSuffix::Double {
            return self.constant(Value::Double(value), Ty::DOUBLE, span);
        }
        let id = self.constant(Value::Float(value as f32), Ty::FLOAT, span);
        if suffix == FloatSuffix::None {
            self.literals.insert(id, value);
        }
        id
    }

    fn name(&mut self, path: ast::Path) -> ExprId {
        let span = path.span;
        match self.lookup(path) {
            Found::Nothing => self.error(span),
            Found::Local(LocalEntry::Variable(local)) => {
                let ty = self.body.local(local).ty;
                self.push(ExprKind::Local(local), ty, span)
            }
            Found::Local(LocalEntry::Symbol(symbol)) => self.push(ExprKind::Size(symbol), Ty::INT, span),
            Found::Local(LocalEntry::Constant(value, ty)) => self.constant(value, ty, span),
            Found::Local(LocalEntry::Type(_)) => self.not_a_value(span, "a type"),
            Found::Entities(entities) => self.entity(entities.first().copied(), span),
        }
    }

    fn entity(&mut self, entity: Option<Entity>, span: Span) -> ExprId {
        match entity {
            Some(Entity::Constant(id)) => {
                if id.module == self.m.module.id {
                    self.m.used_constants.insert(id.index);
                }
                let ty = self.m.module_of(id.module).constants[id.index as usize].ty;
                self.push(ExprKind::Global(id), ty, span)
            }
            Some(Entity::Enumerator(id, index)) => {
                let value = self.m.enumeration(id).values[index as usize].1;
                self.constant(Value::Int(value), Ty::of(Base::Enum(id)), span)
            }
            Some(Entity::Function(_)) => self.not_a_value(span, "a function"),
            Some(Entity::Type(_)) => self.not_a_value(span, "a type"),
            Some(Entity::Category(_)) => self.not_a_value(span, "a struct category"),
            Some(Entity::Annotation(_)) | None => self.not_a_value(span, "an annotation"),
        }
    }

    fn not_a_value(&mut self, span: Span, what: &'static str) -> ExprId {
        let name = self.slice(span).to_string();
        self.emit(span, name_problems::NotAValue { name, what });
        self.error(span)
    }

    fn member(&mut self, x: ExprId, member: ast::Ident, span: Span) -> ExprId {
        let ty = self.body.ty(x);
        if ty.is_error() {
            return self.error(span);
        }
        let name = self.name_of(member);
        let found = match (ty.base, ty.size) {
            (Base::Vector(scalar, size), None) => {
                let index = ["x", "y", "z", "w"].iter().position(|component| *component == name);
                index.filter(|index| *index < size.into()).map(|index| (index, Ty::of(Base::Scalar(scalar))))
            }
            (Base::Struct(id), None) => {
                let fields = &self.m.structure(id).fields;
                let index = fields.iter().position(|field| &*field.name == name);
                index.map(|index| (index, fields[index].ty))
            }
            _ => None,
        };
        if let Some((index, ty)) = found {
            if !self.has_field(x, index, member.span) {
                return self.error(span);
            }
            return self.push(ExprKind::Member(x, index as u32), ty, span);
        }
        let similar = match (ty.base, ty.size) {
            (Base::Struct(id), None) => {
                let definition = self.m.structure(id).clone();
                self.similar(name, definition.fields.iter().map(|field| &*field.name))
            }
            _ => None,
        };
        let ty = self.display(ty);
        self.emit(member.span, name_problems::UnknownMember { ty, name: name.to_string(), similar });
        self.error(span)
    }

    /// Whether the module's version of the language has a field; reports one that came later.
    fn has_field(&mut self, x: ExprId, index: usize, span: Span) -> bool {
        let Base::Struct(id) = self.body.ty(x).base else { return true };
        let version = self.m.module.version;
        let field = &self.m.structure(id).fields[index];
        if field.since > version {
            let (name, since) = (field.name.to_string(), field.since);
            self.emit(span, name_problems::NotInVersion { name, version, since, removed: None });
            return false;
        }
        true
    }

    pub(super) fn index(&mut self, x: ExprId, index: ExprId, span: Span) -> ExprId {
        let ty = self.body.ty(x);
        let index_span = self.body.expr(index).span;
        let Some(index) = self.try_coerce(index, Ty::INT) else {
            let found = self.display(self.body.ty(index));
            self.emit(index_span, problems::IndexNotInt { found });
            return self.error(span);
        };
        let (element, size) = match (ty.base, ty.size) {
            (Base::Error, _) => return self.error(span),
            (_, Some(Size::Known(size))) => (ty.element(), Some(size)),
            (_, Some(Size::Symbol(_))) => (ty.element(), None),
            (Base::Vector(scalar, size), None) => (Ty::of(Base::Scalar(scalar)), Some(size.into())),
            (Base::Matrix(scalar, columns, rows), None) => {
                (Ty::of(Base::Vector(scalar, rows)), Some(columns.into()))
            }
            _ => {
                let ty = self.display(ty);
                self.emit(self.body.expr(x).span, problems::NotIndexable { ty });
                return self.error(span);
            }
        };
        if let (ExprKind::Constant(Value::Int(value)), Some(size)) = (&self.body.expr(index).kind, size) {
            let index = i64::from(*value);
            if index < 0 || index >= size.into() {
                self.emit(index_span, problems::IndexOutOfRange { index, size });
            }
        }
        self.push(ExprKind::Index(x, index), element, span)
    }

    pub(super) fn unary(&mut self, op: ast::UnaryOp, x: ExprId, span: Span) -> ExprId {
        let ty = self.body.ty(x);
        let (graph_op, spelling) = match op {
            ast::UnaryOp::Plus => (UnaryOp::Negate, "+"),
            ast::UnaryOp::Negate => (UnaryOp::Negate, "-"),
            ast::UnaryOp::Not => (UnaryOp::Not, "!"),
            ast::UnaryOp::BitNot => (UnaryOp::BitNot, "~"),
        };
        let Some(result) = operators::unary(graph_op, ty) else {
            let ty = self.display(ty);
            self.emit(span, problems::NoUnaryOperator { op: spelling, ty });
            return self.error(span);
        };
        let x = self.convert(x, result);
        if op == ast::UnaryOp::Plus {
            return x;
        }
        let literal = self.literals.get(&x).copied();
        let folded = match &self.body.expr(x).kind {
            ExprKind::Constant(value) if op == ast::UnaryOp::Negate => fold::unary(graph_op, value),
            _ => None,
        };
        let id = match folded {
            Some(value) => self.constant(value, result, span),
            None => self.push(ExprKind::Unary(graph_op, x), result, span),
        };
        if let (Some(literal), ast::UnaryOp::Negate) = (literal, op) {
            self.literals.insert(id, -literal);
        }
        id
    }

    pub(super) fn binary(&mut self, op: BinaryOp, x: ExprId, y: ExprId, span: Span) -> ExprId {
        let (left, right) = (self.body.ty(x), self.body.ty(y));
        let Some((typed, how)) = operators::binary(op, left, right) else {
            let (left, right) = (self.display(left), self.display(right));
            self.emit(span, problems::NoBinaryOperator { op: spelling(op).to_string(), left, right });
            return self.error(span);
        };
        if let (Base::Enum(a), Base::Enum(b)) = (left.base, right.base)
            && a != b
            && typed.result == Ty::BOOL
        {
            let (left, right) = (self.display(left), self.display(right));
            self.emit(span, problems::DifferentEnums { left, right });
        }
        let (x, y) = (self.convert_as(x, typed.left, how), self.convert_as(y, typed.right, how));
        self.lint_binary(op, x, y, span);
        self.push(ExprKind::Binary(op, x, y), typed.result, span)
    }

    /// A condition: a `bool`.
    pub(super) fn condition(&mut self, id: ast::ExprId) -> ExprId {
        let span = self.nodes.expr(id).span;
        if let ast::ExprKind::Assign(None, ..) = self.nodes.expr(id).kind {
            self.emit(span, flow_problems::AssignmentAsCondition {});
        }
        let condition = self.expr(id);
        let found = self.body.ty(condition);
        if found != Ty::BOOL && !found.is_error() {
            let found = self.display(found);
            self.emit(span, problems::ConditionNotBool { found });
        }
        condition
    }

    pub(super) fn select(&mut self, condition: ExprId, x: ExprId, y: ExprId, span: Span) -> ExprId {
        let (left, right) = (self.body.ty(x), self.body.ty(y));
        let Some((ty, how)) = convert::common(left, right) else {
            let (left, right) = (self.display(left), self.display(right));
            self.emit(span, problems::BranchesDiffer { left, right });
            return self.error(span);
        };
        let (x, y) = (self.convert_as(x, ty, how), self.convert_as(y, ty, how));
        self.lint_select(x, y);
        self.push(ExprKind::Select(condition, x, y), ty, span)
    }

    fn let_in(&mut self, decls: &[ast::VarDecl], body: ast::ExprId, span: Span) -> ExprId {
        self.scopes.enter();
        let mut bindings = Vec::new();
        for decl in decls {
            let ty = self.ty(&decl.ty, TypeUse::Local);
            for variable in &decl.variables {
                let (value, ty) = self.initial_value(variable, ty, decl.ty.span);
                let local = self.declare_local(variable, ty, decl.ty.frequency, false);
                bindings.push((local, value));
            }
        }
        let value = self.expr(body);
        self.leave_block();
        let ty = self.body.ty(value);
        self.push(ExprKind::Let(bindings, value), ty, span)
    }

    /// How a variable of a declared type starts; `None` is `auto`. Also the type that it has.
    pub(super) fn initial_value(
        &mut self,
        variable: &ast::Variable,
        ty: Option<Ty>,
        place: Span,
    ) -> (ExprId, Ty) {
        let span = variable.name.span;
        match (&variable.init, ty) {
            (Init::Value(value), None) => {
                let value = self.expr(*value);
                (value, self.body.ty(value))
            }
            (Init::Value(value), Some(ty)) => {
                let value = self.expr(*value);
                (self.coerce(value, ty), ty)
            }
            (Init::Construct(args), Some(ty)) => {
                let args = self.args(args);
                (self.construct(ty, &args, span), ty)
            }
            (Init::Default, Some(ty)) => (self.push(ExprKind::Default, ty, span), ty),
            (_, None) => {
                self.emit(
                    place,
                    problems::MisplacedAuto { reason: "`auto` needs a value to take its type from" },
                );
                (self.error(span), Ty::ERROR)
            }
        }
    }

    /// Declares a variable or `let` name; its value was checked before, so it cannot refer to itself.
    pub(super) fn declare_local(
        &mut self,
        variable: &ast::Variable,
        ty: Ty,
        frequency: Option<ast::Frequency>,
        mutable: bool,
    ) -> super::hir::LocalId {
        let (span, name) = (variable.name.span, self.name_of(variable.name));
        let uses = self.annotations(&variable.annotations);
        let local = self.body.push_local(Local { name: name.into(), ty, frequency, mutable, span });
        if let Some(first) = self.scopes.declare(name, LocalEntry::Variable(local), span) {
            let first = Some(self.m.sink.place(first));
            self.emit(span, name_problems::Redeclared { name: name.to_string(), first });
        }
        if uses.iter().any(|used| &*used.name == "::anno::unused") {
            self.scopes.mark_unused();
        } else if self.m.standard {
            self.scopes.allow_unused();
        }
        local
    }

    fn step(&mut self, step: Step, x: ast::ExprId, span: Span) -> ExprId {
        self.require_imperative(span);
        let x = self.expr(x);
        let ty = self.body.ty(x);
        if !operators::step(ty) {
            let ty = self.display(ty);
            self.emit(span, problems::NoUnaryOperator { op: if step.up { "++" } else { "--" }, ty });
            return self.error(span);
        }
        self.require_place(x);
        self.push(ExprKind::Step(step, x), ty, span)
    }

    fn assign(&mut self, op: Option<BinaryOp>, x: ast::ExprId, y: ast::ExprId, span: Span) -> ExprId {
        self.require_imperative(span);
        let (x, y) = (self.expr(x), self.expr(y));
        let ty = self.body.ty(x);
        self.require_place(x);
        let Some(op) = op else {
            self.lint_self_assignment(x, y, span);
            let y = self.coerce(y, ty);
            return self.push(ExprKind::Assign(x, y), ty, span);
        };
        let right = self.body.ty(y);
        let typed = operators::binary(op, ty, right);
        match typed {
            Some((typed, how)) if typed.left == ty && typed.result == ty => {
                let y = self.convert_as(y, typed.right, how);
                self.lint_binary(op, x, y, span);
                self.push(ExprKind::AssignOp(op, x, y), ty, span)
            }
            Some(_) if ty.is_error() || right.is_error() => self.error(span),
            _ => {
                let (left, right) = (self.display(ty), self.display(right));
                let op = format!("{}=", spelling(op));
                self.emit(span, problems::NoBinaryOperator { op, left, right });
                self.error(span)
            }
        }
    }

    fn require_imperative(&mut self, span: Span) {
        if !self.imperative {
            self.emit(span, flow_problems::AssignmentInExpression {});
        }
    }

    /// Reports unless an expression is something that can be assigned to.
    fn require_place(&mut self, id: ExprId) {
        if !self.imperative {
            return;
        }
        let span = self.body.expr(id).span;
        let mut at = id;
        let what = loop {
            match &self.body.expr(at).kind {
                ExprKind::Member(x, _) | ExprKind::Index(x, _) => at = *x,
                ExprKind::Local(local) if !self.body.local(*local).mutable => break "a `let` name",
                ExprKind::Local(_) | ExprKind::Error => return,
                ExprKind::Global(_) | ExprKind::Constant(_) | ExprKind::Size(_) => break "a constant",
                _ => break "the result of an expression",
            }
        };
        self.emit(span, problems::NotAssignable { what });
    }
}

/// An operator as it is written.
pub fn spelling(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Add => "+",
        BinaryOp::Sub => "-",
        BinaryOp::Mul => "*",
        BinaryOp::Div => "/",
        BinaryOp::Rem => "%",
        BinaryOp::Shl => "<<",
        BinaryOp::Shr => ">>",
        BinaryOp::UShr => ">>>",
        BinaryOp::BitAnd => "&",
        BinaryOp::BitXor => "^",
        BinaryOp::BitOr => "|",
        BinaryOp::Less => "<",
        BinaryOp::LessEqual => "<=",
        BinaryOp::Greater => ">",
        BinaryOp::GreaterEqual => ">=",
        BinaryOp::Equal => "==",
        BinaryOp::NotEqual => "!=",
        BinaryOp::And => "&&",
        BinaryOp::Or => "||",
    }
}
