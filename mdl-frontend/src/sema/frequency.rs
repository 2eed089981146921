//! What varies over a surface, and whether it is allowed to.
//!
//! Types say `uniform` and `varying` only where a writer said so; the rest follows from the data. An
//! expression varies if it reads the shading state, or a parameter declared `varying`; it may vary if it
//! reads a parameter without qualifier. A variable varies if anything that varies is assigned to it, or
//! if anything is assigned to it where control depends on something that varies. Loops are repeated
//! until nothing changes.
//!
//! Does not: follow values through elements, and through fields only as far as a field is declared
//! `uniform` (otherwise a struct varies as a whole).

use super::ModuleCx;
use super::hir::{Body, DefaultArg, ExprId, ExprKind, FunctionKind, LocalId, Signature, StmtId, StmtKind};
use super::ty::Ty;
use crate::diagnostics::types as problems;
use crate::span::{FileSpan, Span};
use crate::syntax::ast::Frequency;
use std::collections::HashMap;

/// Passes over a body after which everything assigned is taken to vary.
const ROUNDS: usize = 64;

/// How often a value changes, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Freq {
    Uniform,
    /// It depends on a parameter without qualifier.
    Auto(LocalId),
    /// It reads something varying here.
    Varying(Span),
}

impl Freq {
    fn join(self, other: Freq) -> Freq {
        match (self, other) {
            (Freq::Varying(_), _) | (Freq::Auto(_), Freq::Uniform | Freq::Auto(_)) => self,
            _ => other,
        }
    }
}

/// What a function's text tells about its frequency.
pub struct Found {
    /// The function depends on the shading state, whatever its arguments are.
    pub varying: bool,
    /// Which defaults do.
    pub defaults: Vec<bool>,
}

/// Finds out what varies in a function, and reports what must not.
pub fn check(
    m: &mut ModuleCx<'_>,
    body: &Body,
    kind: FunctionKind,
    defaults: &[Option<DefaultArg>],
    signature: &Signature,
) -> Found {
    let mut analysis = Analysis::new(m, body, signature);
    let default_freqs: Vec<Freq> = defaults.iter().map(|default| analysis.default(*default)).collect();
    for round in 0.. {
        analysis.changed = false;
        analysis.body_of(kind);
        if !analysis.changed {
            break;
        }
        if round == ROUNDS {
            analysis.give_up();
            break;
        }
    }
    analysis.report = true;
    let default_freqs: Vec<Freq> = match kind {
        FunctionKind::Forward(_) => default_freqs,
        _ => defaults.iter().map(|default| analysis.default(*default)).collect(),
    };
    for ((index, freq), default) in default_freqs.iter().enumerate().zip(defaults) {
        if let (Some(DefaultArg::Own(id)), Some(param)) = (default, signature.params.get(index))
            && param.frequency == Some(Frequency::Uniform)
        {
            analysis.require_uniform(*freq, body.expr(*id).span, &param.name, Some(param.span.clone()));
        }
    }
    analysis.result = Freq::Uniform;
    analysis.body_of(kind);
    analysis.check_result(signature);
    Found {
        varying: matches!(analysis.result, Freq::Varying(_)),
        defaults: default_freqs.iter().map(|freq| matches!(freq, Freq::Varying(_))).collect(),
    }
}

/// Whether an expression without parameters varies, such as the default of a field.
pub fn varies(m: &mut ModuleCx<'_>, body: &Body, id: ExprId) -> bool {
    let mut analysis = Analysis::bare(m, body);
    analysis.report = true;
    matches!(analysis.expr(id), Freq::Varying(_))
}

struct Analysis<'m, 'a, 'b> {
    m: &'m mut ModuleCx<'a>,
    body: &'b Body,
    locals: Vec<Freq>,
    /// What the path to the current statement depends on.
    control: Freq,
    /// Loops and switches around, innermost last.
    breakable: Vec<StmtId>,
    /// What leaving each loop early depends on.
    exits: HashMap<StmtId, Freq>,
    result: Freq,
    changed: bool,
    report: bool,
}

impl<'m, 'a, 'b> Analysis<'m, 'a, 'b> {
    fn bare(m: &'m mut ModuleCx<'a>, body: &'b Body) -> Self {
        Self {
            m,
            body,
            locals: vec![Freq::Uniform; body.locals.len()],
            control: Freq::Uniform,
            breakable: Vec::new(),
            exits: HashMap::default(),
            result: Freq::Uniform,
            changed: false,
            report: false,
        }
    }

    fn new(m: &'m mut ModuleCx<'a>, body: &'b Body, signature: &Signature) -> Self {
        let mut analysis = Self::bare(m, body);
        for (index, param) in signature.params.iter().enumerate().take(body.locals.len()) {
            analysis.locals[index] = match param.frequency {
                Some(Frequency::Uniform) => Freq::Uniform,
                Some(Frequency::Varying) => Freq::Varying(param.span.span),
                None => Freq::Auto(LocalId(index as u32)),
            };
        }
        analysis
    }

    fn body_of(&mut self, kind: FunctionKind) {
        match kind {
            FunctionKind::Expr(id) => self.result = self.expr(id),
            FunctionKind::Block(id) => self.stmt(id),
            FunctionKind::Prototype | FunctionKind::Intrinsic | FunctionKind::Forward(_) => {}
        }
    }

    fn default(&mut self, default: Option<DefaultArg>) -> Freq {
        match default {
            Some(DefaultArg::Own(id)) => self.expr(id),
            _ => Freq::Uniform,
        }
    }

    /// Takes every variable to vary, in functions that are too tangled to follow.
    fn give_up(&mut self) {
        let locals = self.body.locals.iter().zip(&mut self.locals);
        locals.for_each(|(local, freq)| *freq = freq.join(Freq::Varying(local.span)));
    }

    /// A varying value for a uniform parameter, variable or field.
    fn require_uniform(&mut self, freq: Freq, span: Span, name: &str, declared: Option<FileSpan>) {
        if !self.report {
            return;
        }
        let parameter = declared.filter(|place| !place.file.is_empty());
        let name = name.to_string();
        match freq {
            Freq::Uniform => {}
            Freq::Varying(cause) => {
                let cause = (cause != span).then(|| self.m.sink.place(cause));
                self.m.sink.emit(span, problems::VaryingToUniform { name, cause, parameter });
            }
            Freq::Auto(local) => {
                let local = self.body.local(local);
                let (cause, source) = (self.m.sink.place(local.span), local.name.to_string());
                self.m.sink.emit(span, problems::MaybeVaryingToUniform { name, cause, source, parameter });
            }
        }
    }

    fn check_result(&mut self, signature: &Signature) {
        let uniform = Some(Frequency::Uniform);
        match self.result {
            Freq::Varying(cause)
                if signature.result_frequency == uniform || signature.frequency == uniform =>
            {
                let cause = Some(self.m.sink.place(cause));
                self.m.sink.emit(signature.span.span, problems::VaryingResult { cause });
            }
            Freq::Auto(_) if signature.result_frequency == uniform => {
                self.require_uniform(self.result, signature.span.span, "result", None);
            }
            _ => {}
        }
    }

    fn join_all(&mut self, ids: &[ExprId]) -> Freq {
        ids.iter().fold(Freq::Uniform, |freq, id| freq.join(self.expr(*id)))
    }

    fn expr(&mut self, id: ExprId) -> Freq {
        let body = self.body;
        let expr = body.expr(id);
        match &expr.kind {
            ExprKind::Error | ExprKind::Constant(_) | ExprKind::Global(_) | ExprKind::Size(_) => {
                Freq::Uniform
            }
            ExprKind::Default => self.default_of(expr.ty, expr.span),
            ExprKind::Local(local) => self.locals[local.0 as usize],
            ExprKind::Unary(_, x) | ExprKind::Convert(x) | ExprKind::Category(x) => self.expr(*x),
            ExprKind::Member(x, index) => {
                let whole = self.expr(*x);
                // A uniform field was made from a uniform value.
                if self.is_uniform_field(body.ty(*x), *index) { Freq::Uniform } else { whole }
            }
            ExprKind::Binary(_, x, y) | ExprKind::Index(x, y) => self.expr(*x).join(self.expr(*y)),
            ExprKind::Construct(parts) => self.join_all(parts),
            ExprKind::Struct(fields) => self.fields(fields, expr.ty, expr.span),
            ExprKind::Select(condition, x, y) => {
                let condition_freq = self.expr(*condition);
                if self.m.is_declarative(expr.ty) {
                    self.check_selection(condition_freq, *condition, expr.ty);
                }
                condition_freq.join(self.expr(*x)).join(self.expr(*y))
            }
            ExprKind::Call(..) => self.call(id),
            ExprKind::Resource(resource) => {
                let options: Vec<ExprId> = resource.gamma.into_iter().chain(resource.selector).collect();
                self.join_all(&options)
            }
            ExprKind::Let(bindings, value) => {
                for (local, value) in bindings {
                    let freq = self.expr(*value);
                    self.store(*local, freq, body.expr(*value).span);
                }
                self.expr(*value)
            }
            ExprKind::Assign(place, value) | ExprKind::AssignOp(_, place, value) => {
                let freq = self.expr(*value).join(self.place_freq(*place));
                self.assign(*place, freq, expr.span);
                freq
            }
            ExprKind::Step(_, place) => {
                let freq = self.expr(*place);
                self.assign(*place, freq, expr.span);
                freq
            }
            ExprKind::Sequence(x, y) => {
                self.expr(*x);
                self.expr(*y)
            }
        }
    }

    /// What the indices of a place depend on.
    fn place_freq(&mut self, place: ExprId) -> Freq {
        match self.body.expr(place).kind {
            ExprKind::Member(x, _) => self.place_freq(x),
            ExprKind::Index(x, index) => self.expr(index).join(self.place_freq(x)),
            _ => Freq::Uniform,
        }
    }

    fn assign(&mut self, place: ExprId, freq: Freq, span: Span) {
        let mut at = place;
        loop {
            match self.body.expr(at).kind {
                ExprKind::Member(x, _) | ExprKind::Index(x, _) => at = x,
                ExprKind::Local(local) => return self.store(local, freq.join(self.control), span),
                _ => return,
            }
        }
    }

    fn store(&mut self, local: LocalId, freq: Freq, span: Span) {
        let declared = self.body.local(local);
        if declared.frequency == Some(Frequency::Uniform) {
            let place = self.m.sink.place(declared.span);
            self.require_uniform(freq, span, &declared.name, Some(place).filter(|place| place.span != span));
            return;
        }
        let before = self.locals[local.0 as usize];
        let joined = before.join(freq);
        self.changed |= std::mem::discriminant(&before) != std::mem::discriminant(&joined);
        self.locals[local.0 as usize] = joined;
    }

    fn check_selection(&mut self, freq: Freq, condition: ExprId, ty: Ty) {
        let cause = match freq {
            Freq::Uniform => return,
            Freq::Varying(cause) => cause,
            Freq::Auto(local) => self.body.local(local).span,
        };
        if self.report {
            let (ty, cause) = (self.m.display(ty), Some(self.m.sink.place(cause)));
            let span = self.body.expr(condition).span;
            self.m.sink.emit(span, problems::VaryingSelection { ty, cause });
        }
    }

    /// The default of a type varies if the default of one of its fields does.
    fn default_of(&mut self, ty: Ty, span: Span) -> Freq {
        let Some(id) = ty.base.as_struct() else { return Freq::Uniform };
        match self.m.structure(id).fields.iter().any(|field| field.varying_default) {
            true => Freq::Varying(span),
            false => Freq::Uniform,
        }
    }

    fn is_uniform_field(&self, ty: Ty, index: u32) -> bool {
        let field = ty.base.as_struct().and_then(|id| self.m.structure(id).fields.get(index as usize));
        field.is_some_and(|field| field.uniform)
    }

    fn fields(&mut self, fields: &[Option<ExprId>], ty: Ty, span: Span) -> Freq {
        let Some(id) = ty.base.as_struct() else { return Freq::Uniform };
        let definition = self.m.structure(id).clone();
        let file = self.m.module_of(id.module).identity.file.clone();
        let known = id.module != super::ty::ModuleId::LANGUAGE;
        let mut joined = Freq::Uniform;
        for (given, field) in fields.iter().zip(&definition.fields) {
            let freq = match given {
                Some(id) => self.expr(*id),
                None if field.varying_default => Freq::Varying(span),
                None => Freq::Uniform,
            };
            if let (Some(id), true) = (given, field.uniform) {
                let declared = known.then(|| FileSpan { file: file.clone(), span: field.span });
                self.require_uniform(freq, self.body.expr(*id).span, &field.name, declared);
            }
            joined = joined.join(freq);
        }
        joined
    }

    fn call(&mut self, id: ExprId) -> Freq {
        let body = self.body;
        let ExprKind::Call(callee, args) = &body.expr(id).kind else { return Freq::Uniform };
        let signature = self.m.signature(*callee);
        let mut joined = Freq::Uniform;
        for (index, (arg, param)) in args.iter().zip(&signature.params).enumerate() {
            let freq = match arg {
                Some(arg) => self.expr(*arg),
                None => match self.m.function(*callee).varying_defaults.get(index) {
                    Some(true) => Freq::Varying(body.expr(id).span),
                    _ => Freq::Uniform,
                },
            };
            if let (Some(Frequency::Uniform), Some(arg)) = (param.frequency, arg) {
                self.require_uniform(freq, body.expr(*arg).span, &param.name, Some(param.span.clone()));
            } else {
                joined = joined.join(freq);
            }
        }
        let varying = self.m.function(*callee).varying;
        match signature.result_frequency {
            Some(Frequency::Uniform) => Freq::Uniform,
            _ if varying => Freq::Varying(body.expr(id).span),
            _ => joined,
        }
    }

    /// Runs statements under a further condition.
    fn under(&mut self, condition: Freq, run: impl FnOnce(&mut Self)) {
        let before = self.control;
        self.control = before.join(condition);
        run(self);
        self.control = before;
    }

    fn stmt(&mut self, id: StmtId) {
        let body = self.body;
        match &body.stmt(id).kind {
            StmtKind::Empty => {}
            StmtKind::Block(stmts) => stmts.iter().for_each(|stmt| self.stmt(*stmt)),
            StmtKind::Var(local, value) => {
                let freq = self.expr(*value).join(self.control);
                self.store(*local, freq, body.expr(*value).span);
            }
            StmtKind::Expr(id) => _ = self.expr(*id),
            StmtKind::If(condition, then, otherwise) => {
                let condition = self.expr(*condition);
                self.under(condition, |this| {
                    this.stmt(*then);
                    otherwise.iter().for_each(|otherwise| this.stmt(*otherwise));
                });
            }
            StmtKind::Switch(selector, cases) => {
                let selector = self.expr(*selector);
                self.breakable.push(id);
                self.under(selector, |this| {
                    cases.iter().flat_map(|case| &case.body).for_each(|s| this.stmt(*s))
                });
                self.breakable.pop();
            }
            StmtKind::While(condition, inner) | StmtKind::DoWhile(inner, condition) => {
                let condition = self.expr(*condition);
                self.looped(id, condition, |this| this.stmt(*inner));
            }
            StmtKind::For(init, condition, update, inner) => {
                init.iter().for_each(|init| self.stmt(*init));
                let condition = condition.map_or(Freq::Uniform, |condition| self.expr(condition));
                self.looped(id, condition, |this| {
                    this.stmt(*inner);
                    update.iter().for_each(|update| _ = this.expr(*update));
                });
            }
            StmtKind::Break | StmtKind::Continue => {
                if let Some(exit) = self.breakable.last().copied() {
                    let before = self.exits.get(&exit).copied().unwrap_or(Freq::Uniform);
                    let joined = before.join(self.control);
                    self.changed |= std::mem::discriminant(&before) != std::mem::discriminant(&joined);
                    self.exits.insert(exit, joined);
                }
            }
            StmtKind::Return(value) => self.result = self.result.join(self.expr(*value)).join(self.control),
        }
    }

    fn looped(&mut self, id: StmtId, condition: Freq, run: impl FnOnce(&mut Self)) {
        let exit = self.exits.get(&id).copied().unwrap_or(Freq::Uniform);
        self.breakable.push(id);
        self.under(condition.join(exit), run);
        self.breakable.pop();
    }
}
