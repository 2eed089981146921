//! Statements, and whether the end of each can be reached.

use super::Checker;
use super::hir::{Case, ExprId, ExprKind, Stmt, StmtId, StmtKind};
use super::scope::LocalEntry;
use super::ty::{Base, Ty};
use super::type_expr::TypeUse;
use crate::diagnostics::{flow as problems, names as name_problems, types as type_problems};
use crate::span::Span;
use crate::syntax::ast;
use crate::types::Scalar;
use crate::value::Value;
use std::collections::HashMap;

/// What statements must know of the function around them.
#[derive(Default)]
pub struct Flow {
    /// Type of the result; `None` for `auto` before the first `return`.
    pub result: Option<Ty>,
    /// The first `return` of a function with result `auto`.
    first_return: Option<Span>,
    /// Loops and switches around, innermost last.
    breakable: Vec<Breakable>,
}

impl Flow {
    /// Of a function with this result.
    pub fn of(result: Option<Ty>) -> Self {
        Self { result, ..Self::default() }
    }
}

/// A loop or switch.
struct Breakable {
    is_loop: bool,
    /// A `break` leaves it.
    broken: bool,
    /// A `continue` starts it again.
    continued: bool,
}

/// A checked statement, and whether its end can be reached.
type Checked = (StmtId, bool);

impl<'a> Checker<'_, 'a> {
    fn push_stmt(&mut self, kind: StmtKind, span: Span) -> StmtId {
        self.body.stmts.push(Stmt { kind, span });
        StmtId(self.body.stmts.len() as u32 - 1)
    }

    /// Checks a statement in a block of its own.
    fn scoped(&mut self, id: ast::StmtId) -> Checked {
        self.scopes.enter();
        let checked = self.stmt(id);
        self.leave_block();
        checked
    }

    /// Checks a statement.
    pub(super) fn stmt(&mut self, id: ast::StmtId) -> Checked {
        use ast::StmtKind as S;
        let ast::Stmt { kind, span } = self.nodes.stmt(id);
        let span = *span;
        let (kind, reached) = match kind {
            S::Error | S::Empty => (StmtKind::Empty, true),
            S::Block(stmts) => {
                self.scopes.enter();
                let (stmts, reached) = self.stmts(stmts);
                self.leave_block();
                (StmtKind::Block(stmts), reached)
            }
            S::Item(item) => {
                self.local_item(item, span);
                (StmtKind::Empty, true)
            }
            S::Var(decl) => return (self.variables(decl, span), true),
            S::Expr(expr) => {
                let expr = self.expr(*expr);
                self.lint_effect(expr);
                (StmtKind::Expr(expr), true)
            }
            S::If { .. } => return self.if_chain(id),
            S::Switch(selector, cases) => self.switch(*selector, cases, span),
            S::While(condition, body) => {
                let condition = self.condition(*condition);
                self.lint_empty_body(*body, "while");
                let (body, info) = self.looped(*body);
                let reached = info.broken || !self.is_true(condition);
                (StmtKind::While(condition, body), reached)
            }
            S::DoWhile(body, condition) => {
                let (body, info, body_reached) = self.looped_with_end(*body);
                let condition = self.condition(*condition);
                let repeats = body_reached || info.continued;
                let reached = info.broken || (repeats && !self.is_true(condition));
                (StmtKind::DoWhile(body, condition), reached)
            }
            S::For { init, condition, update, body } => {
                return self.for_loop(*init, *condition, *update, *body, span);
            }
            S::Break => {
                match self.flow.breakable.last_mut() {
                    Some(breakable) => breakable.broken = true,
                    None => self.emit(span, problems::MisplacedBreak {}),
                }
                (StmtKind::Break, false)
            }
            S::Continue => {
                match self.flow.breakable.iter_mut().rev().find(|breakable| breakable.is_loop) {
                    Some(breakable) => breakable.continued = true,
                    None => self.emit(span, problems::MisplacedContinue {}),
                }
                (StmtKind::Continue, false)
            }
            S::Return(value) => (self.return_value(*value, span), false),
        };
        (self.push_stmt(kind, span), reached)
    }

    /// Checks statements in order; reports the first that is never reached.
    fn stmts(&mut self, stmts: &[ast::StmtId]) -> (Vec<StmtId>, bool) {
        let mut reached = true;
        let mut reported = false;
        let mut checked = Vec::with_capacity(stmts.len());
        for id in stmts {
            let ast::Stmt { kind, span } = self.nodes.stmt(*id);
            if !reached && !reported && !matches!(kind, ast::StmtKind::Empty | ast::StmtKind::Item(_)) {
                self.emit(*span, problems::Unreachable {});
                reported = true;
            }
            let (id, ends) = self.stmt(*id);
            checked.push(id);
            reached &= ends;
        }
        (checked, reached)
    }

    fn variables(&mut self, decl: &ast::VarDecl, span: Span) -> StmtId {
        let ty = self.ty(&decl.ty, TypeUse::Local);
        let mut stmts = Vec::with_capacity(decl.variables.len());
        for variable in &decl.variables {
            let (value, ty) = self.initial_value(variable, ty, decl.ty.span);
            if self.m.is_declarative(ty) {
                let ty = self.display(ty);
                self.emit(decl.ty.span, type_problems::ForbiddenType { ty, what: "a variable" });
            }
            self.check_shadowing(variable.name);
            let local = self.declare_local(variable, ty, decl.ty.frequency, true);
            stmts.push(self.push_stmt(StmtKind::Var(local, value), variable.name.span));
        }
        match stmts[..] {
            [stmt] => stmt,
            _ => self.push_stmt(StmtKind::Block(stmts), span),
        }
    }

    /// Reports a variable of a function's outermost block with the name of a parameter.
    fn check_shadowing(&mut self, name: ast::Ident) {
        const BODY: usize = 2;
        let text = self.name_of(name);
        if self.scopes.depth() == BODY
            && let Some(param) = self.body.locals.iter().take(self.params).find(|local| &*local.name == text)
        {
            let parameter = self.m.sink.place(param.span);
            self.scopes.find(text);
            self.emit(name.span, name_problems::ParameterShadowed { name: text.to_string(), parameter });
        }
    }

    fn local_item(&mut self, item: &ast::ItemKind, span: Span) {
        match item {
            ast::ItemKind::Const(decl) => {
                let ty = self.ty(&decl.ty, TypeUse::Local);
                for variable in &decl.variables {
                    let (value, ty) = self.initial_value(variable, ty, decl.ty.span);
                    let Some(value) = self.constant_value(value, "the value of a constant") else {
                        self.declare_local(variable, Ty::ERROR, None, false);
                        self.scopes.allow_unused();
                        continue;
                    };
                    let name = self.name_of(variable.name);
                    self.scopes.declare(name, LocalEntry::Constant(value, ty), variable.name.span);
                }
            }
            ast::ItemKind::Typedef { ty, name } => {
                let ty = self.ty(ty, TypeUse::Other).unwrap_or(Ty::ERROR);
                self.declare_type(*name, ty);
            }
            ast::ItemKind::Struct { name, .. } => {
                let ty = self.apart(|inner| inner.structure(item));
                self.declare_type(*name, ty);
            }
            ast::ItemKind::Enum { name, values, .. } => {
                let (ty, id) = self.apart(|inner| inner.enumeration(item));
                self.declare_type(*name, ty);
                let definition = self.m.enumeration(id).clone();
                for (value, (_, number)) in values.iter().zip(&definition.values) {
                    let entry = LocalEntry::Constant(Value::Int(*number), ty);
                    self.scopes.declare(self.name_of(value.name), entry, value.name.span);
                    self.scopes.allow_unused();
                }
            }
            _ => self.emit(span, problems::Misplaced { what: "this declaration" }),
        }
    }

    fn declare_type(&mut self, name: ast::Ident, ty: Ty) {
        let text = self.name_of(name);
        if let Some(first) = self.scopes.declare(text, LocalEntry::Type(ty), name.span) {
            let first = Some(self.m.sink.place(first));
            self.emit(name.span, name_problems::Redeclared { name: text.to_string(), first });
        }
        self.scopes.allow_unused();
    }

    /// Checks a declaration that sees the types and constants around, but no variables.
    fn apart<T>(&mut self, check: impl FnOnce(&mut Checker<'_, 'a>) -> T) -> T {
        let mut inner = Checker::new(self.m, self.nodes);
        inner.scopes = self.scopes.without_variables();
        let result = check(&mut inner);
        let calls = std::mem::take(&mut inner.calls);
        self.calls.extend(calls);
        result
    }

    /// An `if` with all its `else if`, which may be many: no recursion along the chain.
    fn if_chain(&mut self, id: ast::StmtId) -> Checked {
        let mut links = Vec::new();
        let mut conditions: Vec<ExprId> = Vec::new();
        let mut next = Some(id);
        let mut last = None;
        let mut reached = false;
        while let Some(id) = next.take() {
            let ast::Stmt { kind, span } = self.nodes.stmt(id);
            let ast::StmtKind::If { condition, then, otherwise } = kind else {
                let (stmt, ends) = self.scoped(id);
                reached |= ends;
                last = Some(stmt);
                break;
            };
            let checked = self.condition(*condition);
            self.lint_same_condition(&conditions, checked);
            conditions.push(checked);
            if otherwise.is_none() {
                self.lint_empty_body(*then, "if");
            }
            self.lint_same_branches(*then, *otherwise);
            let (then, ends) = self.scoped(*then);
            reached |= ends || otherwise.is_none();
            links.push((checked, then, *span));
            next = *otherwise;
        }
        for (condition, then, span) in links.into_iter().rev() {
            last = Some(self.push_stmt(StmtKind::If(condition, then, last), span));
        }
        // The chain has at least its first link.
        let stmt = last.unwrap_or_else(|| self.push_stmt(StmtKind::Empty, Span::default()));
        (stmt, reached)
    }

    fn looped(&mut self, body: ast::StmtId) -> (StmtId, Breakable) {
        let (body, info, reached) = self.looped_with_end(body);
        if !reached && !info.continued {
            let span = self.body.stmt(body).span;
            self.emit(Span { end: span.start, ..span }, problems::LoopRunsOnce {});
        }
        (body, info)
    }

    fn looped_with_end(&mut self, body: ast::StmtId) -> (StmtId, Breakable, bool) {
        self.flow.breakable.push(Breakable { is_loop: true, broken: false, continued: false });
        let (body, reached) = self.scoped(body);
        let info = self.flow.breakable.pop();
        let info = info.unwrap_or(Breakable { is_loop: true, broken: false, continued: false });
        (body, info, reached)
    }

    fn for_loop(
        &mut self,
        init: Option<ast::StmtId>,
        condition: Option<ast::ExprId>,
        update: Option<ast::ExprId>,
        body: ast::StmtId,
        span: Span,
    ) -> Checked {
        self.scopes.enter();
        let init = init.map(|init| self.stmt(init).0);
        let condition = condition.map(|condition| self.condition(condition));
        let update = update.map(|update| {
            let update = self.expr(update);
            self.lint_effect(update);
            update
        });
        let (body, info) = self.looped(body);
        self.leave_block();
        let endless = condition.is_none_or(|condition| self.is_true(condition));
        (self.push_stmt(StmtKind::For(init, condition, update, body), span), info.broken || !endless)
    }

    fn switch(&mut self, selector: ast::ExprId, cases: &[ast::Case], span: Span) -> (StmtKind, bool) {
        let selector = self.expr(selector);
        let ty = self.body.ty(selector);
        if !matches!((ty.base, ty.size), (Base::Error | Base::Enum(_) | Base::Scalar(Scalar::Int), _)) {
            let found = self.display(ty);
            self.emit(self.body.expr(selector).span, problems::SwitchType { found });
        }
        if !cases.iter().any(|case| case.label.is_some()) {
            self.emit(span, problems::SwitchWithoutCase {});
        }
        let mut seen: HashMap<Option<i32>, Span> = HashMap::default();
        let mut checked = Vec::with_capacity(cases.len());
        let mut reached = true;
        self.flow.breakable.push(Breakable { is_loop: false, broken: false, continued: false });
        for case in cases {
            let label = match case.label {
                None => Some(None),
                Some(label) => self.case_label(label, ty).map(Some),
            };
            if let Some(label) = label
                && let Some(first) = seen.insert(label, case.span)
            {
                self.report_duplicate(label, case.span, first);
            }
            self.scopes.enter();
            let (body, ends) = self.stmts(&case.body);
            self.leave_block();
            reached = ends;
            checked.push(Case { label: label.flatten(), body });
        }
        let broken = self.flow.breakable.pop().is_some_and(|info| info.broken);
        let has_default = seen.contains_key(&None);
        if let (Base::Enum(id), false) = (ty.base, has_default) {
            self.lint_missing_cases(id, &seen, span);
        }
        let selector = if ty.is_error() { selector } else { self.convert(selector, Ty::INT) };
        (StmtKind::Switch(selector, checked), reached || broken || !has_default)
    }

    /// The value of a label.
    fn case_label(&mut self, label: ast::ExprId, selector: Ty) -> Option<i32> {
        let span = self.nodes.expr(label).span;
        let label = self.expr(label);
        let ty = self.body.ty(label);
        if ty.is_error() {
            return None;
        }
        if !matches!(ty.base, Base::Enum(_) | Base::Scalar(Scalar::Int)) {
            self.emit(span, problems::CaseNotConstant {});
            return None;
        }
        if let (Base::Enum(a), Base::Enum(b)) = (ty.base, selector.base)
            && a != b
        {
            let (left, right) = (self.display(selector), self.display(ty));
            self.emit(span, type_problems::DifferentEnums { left, right });
        }
        match self.m.eval(&self.body, label) {
            Ok(Value::Int(value)) => Some(value),
            Ok(_) => None,
            Err(_) => {
                self.emit(span, problems::CaseNotConstant {});
                None
            }
        }
    }

    fn report_duplicate(&mut self, label: Option<i32>, span: Span, first: Span) {
        let first = self.m.sink.place(first);
        match label {
            None => self.emit(span, problems::DuplicateDefault { first }),
            Some(label) => self.emit(span, problems::DuplicateCase { label: format!("`{label}`"), first }),
        }
    }

    fn return_value(&mut self, value: Option<ast::ExprId>, span: Span) -> StmtKind {
        let Some(value) = value else {
            self.emit(span, problems::ReturnWithoutValue {});
            return StmtKind::Empty;
        };
        let value = self.expr(value);
        let ty = self.body.ty(value);
        match (self.flow.result, self.flow.first_return) {
            (None, _) => {
                self.flow.result = Some(ty);
                self.flow.first_return = Some(self.body.expr(value).span);
                StmtKind::Return(value)
            }
            (Some(first_ty), Some(place)) if first_ty != ty && !ty.is_error() && !first_ty.is_error() => {
                let (found, first) = (self.display(ty), self.display(first_ty));
                let place = self.m.sink.place(place);
                self.emit(
                    self.body.expr(value).span,
                    type_problems::AutoReturnsDiffer { found, first, place },
                );
                StmtKind::Return(value)
            }
            (Some(result), _) => StmtKind::Return(self.coerce(value, result)),
        }
    }

    /// Whether a condition is constantly true.
    fn is_true(&self, condition: ExprId) -> bool {
        matches!(self.body.expr(condition).kind, ExprKind::Constant(Value::Bool(true)))
    }

    /// Leaves a block; warns of names that were not used.
    pub(super) fn leave_block(&mut self) {
        for local in self.scopes.leave() {
            self.lint_use(&local, |name| name_problems::UnusedVariable { name });
        }
    }
}
