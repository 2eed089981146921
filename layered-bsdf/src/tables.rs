//! Tables that programs refer to by number: measured data too large for parameter slots.
//!
//! A table is a list of records of four floats. Natively a [`Program`] carries the tables it refers to; as
//! WGSL a record is what the stub [`text::table_record_at`] returns, whose place is taken by a lookup in a
//! buffer of words ([`Tables::words`], [`crate::wgsl::source_with_tables`]). So this module is written twice, as
//! Rust ([`code`]) and as what WGSL sees of it ([`text`]).

use std::sync::Arc;
use wgsl_rs::wgsl;

/// Most records of a table: numbers up to here are exact in `f32`, as which tables hold them.
pub const MAX_RECORDS: usize = 1 << 24;

/// Records of four floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    records: Vec<[f32; 4]>,
}

/// A table that is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a table of {0} records is too large; {MAX_RECORDS} are supported")]
pub struct TableSize(pub usize);

impl Table {
    /// At most [`MAX_RECORDS`] records.
    pub fn new(records: Vec<[f32; 4]>) -> Result<Self, TableSize> {
        if records.len() > MAX_RECORDS { Err(TableSize(records.len())) } else { Ok(Self { records }) }
    }

    /// The records.
    pub fn records(&self) -> &[[f32; 4]] {
        &self.records
    }
}

/// Tables by number; cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// None if there are none: most programs, whose copies then cost nothing more.
    list: Option<Arc<[Option<Arc<Table>>]>>,
}

impl Tables {
    /// A table per number; none where a program refers to nothing.
    pub fn new(list: Vec<Option<Arc<Table>>>) -> Self {
        Self { list: list.iter().any(Option::is_some).then(|| list.into()) }
    }

    /// Whether there is no table.
    pub fn is_empty(&self) -> bool {
        self.list.is_none()
    }

    /// The tables as words, as [`crate::wgsl::source_with_tables`] reads them; none if they are too many for a
    /// word to count.
    pub fn words(&self) -> Option<Vec<u32>> {
        let list = self.list.as_deref().unwrap_or_default();
        let records = |table: &Option<Arc<Table>>| table.as_ref().map_or(0, |table| table.records.len());
        let mut next = 1 + 2 * list.len();
        let mut words = vec![list.len() as u32];
        for table in list {
            words.extend([u32::try_from(next).ok()?, records(table) as u32]);
            next += 4 * records(table);
        }
        u32::try_from(next).ok()?;
        let records = list.iter().flatten().flat_map(|table| table.records.as_flattened());
        words.extend(records.map(|x| x.to_bits()));
        Some(words)
    }

    /// A record of a table; zeros where there is none.
    #[inline]
    pub fn record(&self, table: u32, index: u32) -> [f32; 4] {
        let table = self.list.as_ref().and_then(|list| list.get(table as usize)?.as_ref());
        table.and_then(|table| table.records.get(index as usize).copied()).unwrap_or([0.0; 4])
    }
}

#[wgsl]
#[allow(missing_docs, unused_variables, reason = "the macro adds items; stubs do not use their arguments")]
pub mod text {
    //! What WGSL sees.
    use wgsl_rs::std::*;

    /// A program: `count` nodes in preorder.
    #[derive(Clone, Copy, Debug)]
    pub struct Program {
        /// Number of nodes, at least 1.
        pub count: u32,
        /// The nodes.
        pub nodes: [Vec4u; 64],
    }

    /// A stub: record `index` of table `table`, to be replaced by who runs this.
    pub fn table_record_at(table: u32, index: u32) -> Vec4f {
        vec4f(0.0, 0.0, 0.0, 0.0)
    }

    /// Record `index` of table `table` of a program.
    pub fn table_record(program: ptr!(function, Program), table: u32, index: u32) -> Vec4f {
        table_record_at(table, index)
    }
}

pub mod code {
    //! The same natively.
    use super::Tables;
    pub use super::text::WGSL_SOURCE;
    use wgsl_rs::std::{Vec4f, Vec4u, vec4f};

    /// A program: `count` nodes in preorder.
    #[derive(Clone, Debug)]
    pub struct Program {
        /// Number of nodes, at least 1.
        pub count: u32,
        /// The nodes.
        pub nodes: [Vec4u; 64],
        /// What its nodes refer to by number.
        pub tables: Tables,
    }

    /// Record `index` of table `table` of a program.
    #[inline]
    pub fn table_record(program: &mut Program, table: u32, index: u32) -> Vec4f {
        let [x, y, z, w] = program.tables.record(table, index);
        vec4f(x, y, z, w)
    }
}
pub use code::{Program, table_record};

impl Program {
    /// As executors of the WGSL text take it: the count, then the words of the nodes.
    pub fn words(&self) -> Vec<u32> {
        std::iter::once(self.count).chain(self.nodes.iter().flat_map(|n| [n.x, n.y, n.z, n.w])).collect()
    }
}
