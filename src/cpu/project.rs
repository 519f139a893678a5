//! The modes that project along rays: they read a window in place of the table.

use super::packet::Packet;
use crate::lattice::Ray;
use crate::mode::{Mode, Parameters};

/// A window and what becomes of the places in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    mode: Mode,
    parameters: Parameters,
}

impl Projection {
    /// What `mode` projects, if it does.
    pub(super) fn of(mode: Mode, parameters: Parameters) -> Option<Self> {
        let projects = matches!(mode, Mode::Mip(_) | Mode::Minip(_) | Mode::Mean(_));
        projects.then_some(Self { mode, parameters })
    }

    /// Adds the place of table coordinate `x` to a ray's state, of which one channel is used, in the `wanted` lanes; the
    /// lanes in which that made a difference. Twin of `shaders/shared/window.inc.wgsl` and the modes' own.
    #[inline(always)]
    pub(super) fn add<P: Packet>(&self, state: &mut P, x: P, wanted: P::Mask) -> P::Mask {
        let p = &self.parameters;
        let v = (x - P::splat(p.window_low)) * P::splat(p.window_scale);
        let v = v.min(P::splat(1.0));
        let v = v.keep(P::and(wanted, P::splat(p.window_dead).lt(v)));
        if let Mode::Mean(_) = self.mode {
            *state = *state + v;
            return P::splat(0.0).lt(v);
        }
        let is_more = state.lt(v);
        *state = P::select(is_more, v, *state);
        is_more
    }

    /// Whether nothing behind can make a difference.
    #[inline(always)]
    pub(super) fn done<P: Packet>(&self, state: P) -> P::Mask {
        let most = match self.mode {
            Mode::Mean(_) => f64::INFINITY,
            _ => 1.0,
        };
        P::splat(most).le(state)
    }

    /// The pixels of rays.
    #[inline(always)]
    pub(super) fn finish<P: Packet>(&self, state: P, ray: &Ray<P>) -> [P; 4] {
        let zero = P::splat(0.0);
        match self.mode {
            Mode::Minip(_) => [zero, zero, zero, state],
            Mode::Mean(_) => [state / (ray.k_end - ray.k_near).max(P::splat(1.0)); 4],
            _ => [state; 4],
        }
    }
}
