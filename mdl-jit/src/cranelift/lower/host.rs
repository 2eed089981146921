//! Calls out of compiled code, and the ways in which a run ends early.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{InstBuilder, Value, types};
use naga::Handle;

use super::{FaultSite, Lower, Lowered, Val};
use crate::cranelift::abi;
use crate::cranelift::emit::{Data, Emit, V, lanes_type, memory, scalar_type};
use crate::types::Kind;

impl Lower<'_, '_> {
    /// Calls the wide kernel of a library function on the leaves of its arguments, if there is one and they
    /// vary. It computes inactive lanes, too.
    pub(super) fn call_wide(&mut self, callee: Handle<naga::Function>, args: &[Val]) -> Option<Val> {
        let kernel = self
            .noise
            .filter(|_| !self.single && self.plan.get(callee).name == crate::cranelift::wide::NOISE)?;
        let leaves: Vec<V> = args.iter().flat_map(|&a| self.leaves(a).to_vec()).collect();
        if !leaves.iter().any(|v| v.is_varying()) {
            return None;
        }
        let lanes: Vec<Value> = leaves.into_iter().map(|v| self.e.lanes(v)).collect();
        let call = self.e.b.ins().call(kernel, &lanes);
        let result = self.e.b.inst_results(call)[0];
        Some(self.keep(&[Emit::varying_leaf(Kind::F32, result)]))
    }

    /// Calls a function of the host for the active lanes.
    pub(super) fn call_host(
        &mut self,
        callee: Handle<naga::Function>,
        args: Vec<Val>,
    ) -> Lowered<Option<Val>> {
        let function = self.plan.get(callee);
        let kinds = function.result.map_or(Ok(Vec::new()), |ty| self.plan.types.kinds(ty))?;
        let leaves: Vec<V> = args.iter().flat_map(|&a| self.leaves(a).to_vec()).collect();
        let varying = leaves.iter().any(|v| v.is_varying());
        let rows = self.slot(16 * (leaves.len() + kinds.len() + 1))?;
        let address = self.e.b.ins().stack_addr(types::I64, rows, 0);
        for (i, &v) in leaves.iter().enumerate() {
            // Truth values are passed as masks in any case.
            let x = if varying || v.kind == Kind::Bool { self.e.lanes(v) } else { self.e.scalar(v) };
            self.e.b.ins().store(memory(), x, address, 16 * i as i32);
        }
        let mask = if !varying {
            self.e.b.ins().iconst(types::I32, 1)
        } else if self.all_active() {
            self.e.b.ins().iconst(types::I32, 15)
        } else {
            let exec = self.exec_mask();
            self.e.b.ins().vhigh_bits(types::I32, exec)
        };
        let index = self.host_names.iter().position(|&n| n == callee.index()).unwrap_or_else(|| {
            self.host_names.push(callee.index());
            self.host_names.len() - 1
        });
        let table = self.context_word(abi::HOST);
        let number = self.e.b.ins().iconst(types::I32, index as i64);
        let counts = self.e.b.ins().iconst(types::I32, ((leaves.len() << 16) | kinds.len()) as i64);
        self.e.b.ins().call(self.host, &[table, number, mask, counts, address]);
        let at = 16 * (leaves.len() + kinds.len()) as i32;
        let status = self.e.b.ins().load(types::I32, memory(), address, at);
        self.fault_if(status, FaultSite::Host { index });
        let mut out = Vec::new();
        for (i, kind) in kinds.into_iter().enumerate() {
            let at = 16 * (leaves.len() + i) as i32;
            let ty = match (varying, kind) {
                (true, _) => lanes_type(kind),
                (false, Kind::Bool) => types::I32,
                (false, _) => scalar_type(kind),
            };
            let mut x = self.e.b.ins().load(ty, memory(), address, at);
            if kind == Kind::Bool {
                let zero = if varying { self.e.vector_const(ty, 0) } else { self.e.b.ins().iconst(ty, 0) };
                x = self.e.b.ins().icmp(IntCC::NotEqual, x, zero);
            }
            out.push(V { kind, data: if varying { Data::Varying(x) } else { Data::Uniform(x) } });
        }
        Ok(function.result.map(|_| self.keep(&out)))
    }

    /// Ends the run with a fault where `condition`, a scalar, is not zero.
    pub(super) fn fault_if(&mut self, condition: Value, site: FaultSite) {
        self.faults.push(site);
        let (fault, go_on) = (self.e.b.create_block(), self.e.b.create_block());
        self.e.b.set_cold_block(fault);
        self.e.b.ins().brif(condition, fault, &[], go_on, &[]);
        self.e.b.seal_block(fault);
        self.e.b.seal_block(go_on);
        self.e.b.switch_to_block(fault);
        let at = 8 * abi::FAULT as i32;
        self.e.b.ins().store(memory(), self.offset, self.context, at);
        let number = self.e.long(self.faults.len() as i64);
        self.e.b.ins().return_(&[number]);
        self.e.b.switch_to_block(go_on);
    }
}
