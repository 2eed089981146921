//! Why arguments do not fit, in words.

use super::Checker;
use super::call::{CallArg, Misfit};
use super::hir::Signature;
use super::ty::{DefId, Size};
use crate::diagnostics::calls as problems;
use crate::span::{FileSpan, Span};
use std::sync::Arc;

impl<'a> Checker<'_, 'a> {
    /// Reports why no candidate fits.
    pub(super) fn report_misfit(&mut self, candidates: &[DefId], args: &[CallArg<'a>], callee: Span) {
        let function = self.slice(callee).to_string();
        if let [id] = candidates {
            let signature = self.m.signature(*id);
            if let Err(misfit) = self.fit(&signature, args) {
                self.report_one_misfit(&function, &signature, args, &misfit, callee);
            }
            return;
        }
        // A name that no overload has is the mistake, whatever the types are.
        let signatures: Vec<Arc<Signature>> = candidates.iter().map(|id| self.m.signature(*id)).collect();
        let misfits: Vec<_> = signatures.iter().filter_map(|s| self.fit(s, args).err()).collect();
        if let Some(Misfit::UnknownName(index)) = misfits.first()
            && misfits.iter().all(|misfit| *misfit == Misfit::UnknownName(*index))
            && let Some((name, span)) = args[*index].name
        {
            let names = signatures.iter().flat_map(|signature| &signature.params).map(|param| &*param.name);
            let similar = self.similar(name, names);
            let name = name.to_string();
            self.emit(span, problems::UnknownParameter { function, name, similar, declared: None });
            return;
        }
        let candidates: Vec<FileSpan> = signatures.iter().take(4).map(|s| s.span.clone()).collect();
        let args = self.describe(args);
        self.emit(callee, problems::NoOverload { function, args, candidates });
    }

    /// Reports why one signature does not fit.
    pub(super) fn report_one_misfit(
        &mut self,
        function: &str,
        signature: &Signature,
        args: &[CallArg<'a>],
        misfit: &Misfit,
        callee: Span,
    ) {
        let function = function.to_string();
        let declared = Some(signature.span.clone()).filter(|span| !span.file.is_empty());
        match *misfit {
            Misfit::UnknownName(index) => {
                let (name, span) = args[index].name.unwrap_or(("", callee));
                let similar = self.similar(name, signature.params.iter().map(|param| &*param.name));
                let name = name.to_string();
                self.emit(span, problems::UnknownParameter { function, name, similar, declared });
            }
            Misfit::TooMany(index) => {
                let parameters = signature.params.len();
                self.emit(args[index].span, problems::TooManyArguments { function, parameters, declared });
            }
            Misfit::Twice(index, first) => {
                let span = args[index].name.map_or(args[index].span, |(_, span)| span);
                let name = args[index].name.map(|(name, _)| name.to_string()).unwrap_or_default();
                let first = self.m.sink.place(args[first].span);
                self.emit(span, problems::ArgumentTwice { name, first });
            }
            Misfit::Missing(index) => {
                let name = signature.params[index].name.to_string();
                self.emit(callee, problems::MissingArgument { function, name, declared });
            }
            Misfit::Type(arg, index) => {
                let param = &signature.params[index];
                let found = self.display(self.body.ty(args[arg].value));
                let expected = self.m.display_with(param.ty, &signature.symbols);
                let declared = Some(param.span.clone()).filter(|span| !span.file.is_empty());
                let name = param.name.to_string();
                self.emit(args[arg].span, problems::ArgumentType { name, found, expected, declared });
            }
            Misfit::Sizes(index, first, second) => {
                let symbol = match signature.params[index].ty.size {
                    Some(Size::Symbol(id)) => signature.symbols[id.0 as usize].to_string(),
                    _ => String::new(),
                };
                let (first, second) = (self.describe_size(first), self.describe_size(second));
                self.emit(callee, problems::ArraySizesDiffer { symbol, first, second });
            }
        }
    }

    fn describe_size(&self, size: Size) -> String {
        match size {
            Size::Known(size) => size.to_string(),
            Size::Symbol(id) => format!("`{}`", self.symbols.get(id.0 as usize).map_or("N", |name| name)),
        }
    }

    /// Types of arguments as a user writes them.
    pub(super) fn describe(&self, args: &[CallArg<'a>]) -> String {
        let describe = |arg: &CallArg<'a>| {
            let ty = self.display(self.body.ty(arg.value));
            arg.name.map_or(ty.clone(), |(name, _)| format!("{name}: {ty}"))
        };
        const SHOWN: usize = 8;
        let mut parts: Vec<String> = args.iter().take(SHOWN).map(describe).collect();
        if args.len() > SHOWN {
            parts.push("...".to_string());
        }
        parts.join(", ")
    }
}
