//! The fibre beam against OpenSees, plane-stress finite elements, limit analyses and the buckling curves.

mod base;
mod bits;
mod buckling;
mod cases;
mod correction;
mod found;
mod hollow;
mod known;
mod modes;
mod movement;
mod plane;
mod plateau;
mod reference;
mod robustness;
mod rotation;
mod shear;
mod space;
