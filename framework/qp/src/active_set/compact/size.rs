//! How much the compiler knows of a problem's size: loops of a length that it knows take half the time (of factorising
//! H), and each such length costs seconds of compiling.

use crate::active_set::kernels::padded;

/// The size of a problem.
pub(super) trait Size: Copy {
    /// Variables.
    fn n(self) -> usize;

    /// Variables with padding.
    fn stride(self) -> usize;
}

/// As many variables as the compiler is told, all lanes full.
#[derive(Clone, Copy)]
pub(super) struct Exactly<const S: usize>;

impl<const S: usize> Size for Exactly<S> {
    #[inline(always)]
    fn n(self) -> usize {
        S
    }

    #[inline(always)]
    fn stride(self) -> usize {
        S
    }
}

/// So many variables, and with padding as many as the compiler is told.
#[derive(Clone, Copy)]
pub(super) struct Padded<const S: usize>(pub(super) usize);

impl<const S: usize> Size for Padded<S> {
    #[inline(always)]
    fn n(self) -> usize {
        self.0
    }

    #[inline(always)]
    fn stride(self) -> usize {
        S
    }
}

/// Any number of variables.
#[derive(Clone, Copy)]
pub(super) struct Any(pub(super) usize);

impl Size for Any {
    #[inline(always)]
    fn n(self) -> usize {
        self.0
    }

    #[inline(always)]
    fn stride(self) -> usize {
        padded(self.0)
    }
}
