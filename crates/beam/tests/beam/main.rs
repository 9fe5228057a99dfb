//! The fibre beam against OpenSees, plane-stress finite elements, limit analyses and the buckling curves.

mod bits;
mod buckling;
mod correction;
mod cost;
mod found;
mod movement;
mod plane;
mod reference;
mod robustness;
mod shear;
mod space;
