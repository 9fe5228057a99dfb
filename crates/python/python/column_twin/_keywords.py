"""The keywords of every parameter.

This file is generated from the table of parameters (src/parameters/table.rs); do not edit it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict, Union

import numpy as np
import numpy.typing as npt

from ._range import AxisNames, AxisNumbers

Number = Union[float, "np.number[Any]"]
Whole = Union[int, "np.integer[Any]"]
Numbers = Union[Sequence[float], npt.NDArray[Any]]
Text = Union[str, "os.PathLike[str]"]


class ParameterKeywords(TypedDict, total=False):
    """A parameter, by its name."""

    column_id: Text
    """name of the column in messages; impact events for another column are rejected, or in a fleet ignored"""
    frame_id: Text
    """coordinate frame of the column in messages, with its origin at the base"""
    publish_rate: Number
    """rate at which state and hinge forces are published during a response; at most once per step, with the period rounded to whole steps [Hz]"""
    use_sim_time: bool
    """take the time from the topic /clock, as every ROS 2 node does"""
    start_type_description_service: bool
    """offer the service ~/get_type_description, as every ROS 2 node does"""
    site__x: Number
    """position of the column in the plan of its fleet, to the right; columns of a fleet that share a position with another one, or give none, are shown in rows below the plan [m]"""
    site__y: Number
    """position of the column in the plan of its fleet, upwards in the picture; see `site.x` [m]"""
    geometry__height: Number
    """height of the column. With it, the impact point is where the vehicle strikes (`column-twin vehicles` lists the heights: cars 0.5 m, forklift trucks 0.75 m, lorries 1.25 m), unless `geometry.length_below` or the impact gives a height, and `geometry.length_above` is the rest. Both lengths replace it where they are given later: in a later file or section, on the command line, or by a change of both together [m]"""
    geometry__length_below: Number
    """L_a: height of the impact point above the base [m]"""
    geometry__length_above: Number
    """L_b: distance from the impact point to the top [m]"""
    section__name: Text
    """rolled section, bent about its strong axis; empty: the section is user-defined. If files and overrides give one of the numbers but no name, the name is empty"""
    section__area: Number
    """A: cross-sectional area; overrides the area of a named section [m^2]"""
    section__second_moment: Number
    """I: second moment of area; overrides the value of a named section [m^4]"""
    section__mass_per_length: Number
    """m_l: mass per length; overrides the value of a named section [kg/m]"""
    section__height: Number
    """h: height in the plane of bending, for strain rates; overrides the value of a named section [m]"""
    section__width: Number
    """b: width of the flanges, for the shear of the web; overrides the value of a named section [m]"""
    section__web_thickness: Number
    """t_w: thickness of the web, for its shear; overrides the value of a named section. A user-defined section yields in shear if it has this and `section.height` [m]"""
    section__flange_thickness: Number
    """t_f: thickness of the flanges, for the shear of the web; overrides the value of a named section [m]"""
    section__shape: Literal["i_or_h", "rectangular_hollow", "circular_hollow"]
    """shape of a user-defined section. rectangular_hollow: `section.height` and `section.width` over walls of the thickness `section.web_thickness`; circular_hollow: the diameter is `section.height`, the thickness of the wall `section.web_thickness`"""
    steel__grade: Text
    """steel grade, nominal values for thicknesses up to 40 mm (EN 1993-1-1, table 3.1); empty: the steel is user-defined. If files and overrides give one of the numbers but no grade, the grade is empty"""
    steel__young_modulus: Number
    """E: Young's modulus; overrides the value of a named grade [Pa]"""
    steel__yield_strength: Number
    """f_y: yield strength; overrides the value of a named grade [Pa]"""
    resistance__moment: Number
    """M^p: plastic moment resistance without normal force [N m]"""
    resistance__axial: Number
    """N^p: plastic axial resistance (squash load) [N]"""
    resistance__shear: Number
    """V_s: plastic resistance of a bar against shear, all of it [N]"""
    yield_surface__alpha: Number
    """alpha: exponent of the moment (Eq 28); 1 with beta = 1.3 is Duan-Chen, 2 with beta = 2 an ellipse"""
    yield_surface__beta: Number
    """beta: exponent of the normal force (Eq 28)"""
    yield_surface__gamma: Number
    """gamma: the whole sum is raised to 1/gamma (Eq 28), which scales the plastic multiplier but not the surface"""
    hinge__elastic_law: Literal["uncoupled", "coupled"]
    """uncoupled: the paper's independent springs (Eqs 47-48); coupled: the elastic beam, exact for any end rotations"""
    hinge__stiffness_1a: Number
    """rotational stiffness of hinge 1a, below the impact point; only with the uncoupled law [N m/rad]"""
    hinge__stiffness_1b: Number
    """rotational stiffness of hinge 1b, above the impact point; only with the uncoupled law [N m/rad]"""
    hinge__stiffness_2: Number
    """rotational stiffness of hinge 2, at the top; only with the uncoupled law and a built-in top [N m/rad]"""
    hinge__stiffness_3: Number
    """rotational stiffness of hinge 3, at the base; only with the uncoupled law and a built-in base [N m/rad]"""
    support__base: Literal["built_in", "pinned", "semi_rigid"]
    """rotational support of the base"""
    support__base_stiffness: Number
    """rotational stiffness of a semi-rigid base [N m/rad]"""
    support__top: Literal["built_in", "pinned", "semi_rigid", "free"]
    """support of the top: rotational, or free for a cantilever such as a bollard, which then needs `top.load: 0` and `top.spring_stiffness: 0`"""
    support__top_stiffness: Number
    """rotational stiffness of a semi-rigid top [N m/rad]"""
    base__connection: Literal["none", "plate"]
    """how the base is connected; none: nothing is known of it, and the assessment assumes a plate for a named section that is built in; plate: a plate with anchors, which needs the other parameters of this group and `section.name`. Its moment and its shear limit the base in the response, in which the foot may slip and the anchors fracture, and its initial stiffness replaces a base that is built in"""
    base__plate_thickness: Number
    """t_p: thickness of the base plate [m]"""
    base__plate_length: Number
    """length of the base plate in the plane of bending, parallel to the web [m]"""
    base__plate_width: Number
    """width of the base plate, parallel to the flanges [m]"""
    base__anchor_count: Whole
    """number of anchors in two lines parallel to the flanges, half of them in each; even; 0 without a plate"""
    base__anchor_diameter: Number
    """nominal diameter of the anchors, a thread of the coarse series such as 0.024 [m]"""
    base__anchor_grade: Literal["none", "4.6", "5.6", "6.8", "8.8"]
    """property class of the anchors, in quotes; stronger ones than 8.8 may not bear shear (EN 1993-1-8, 6.2.2); none without a plate"""
    base__anchor_distance: Number
    """z_T: distance of each line of anchors from the axis of the section [m]"""
    base__concrete: Literal["none", "C12/15", "C16/20", "C20/25", "C25/30", "C30/37", "C35/45", "C40/50", "C45/55", "C50/60"]
    """strength class of the concrete under the plate; none without a plate"""
    base__friction: Number
    """C_f: coefficient of friction between plate and grout; 0.2 for sand and cement (EN 1993-1-8, 6.2.2)"""
    top__spring_stiffness: Number
    """k_s: stiffness of the vertical spring at the top, which represents the rest of the structure and takes load off a column that shortens. Unless given, 0 for a section by name, 1e7 (the paper's example) for a user-defined one [N/m]"""
    top__mass: Number
    """m_2: lumped mass at the top [kg]"""
    top__load: Number
    """P: constant vertical load at the top, positive in compression [N]"""
    top__redistribution_limit: Number
    """largest force that the structure above is proven to take off the column. The verdict compares with top.load less the force that the spring takes, at most this; needs top.redistribution_proof and a top.spring_stiffness. The response has the whole spring in any case [N]"""
    top__redistribution_proof: Text
    """where the proof of top.redistribution_limit is found, such as the number of a calculation; every verdict states it"""
    top__load_basis: Literal["present", "accidental"]
    """meaning of top.load, which every verdict states. present: the load that the column carries now; accidental: the load of the accidental combination of EN 1990 (6.4.3.3), with its psi factors"""
    impact__mass: Number
    """m_c: total mass of the vehicle; all masses of a deformable one, and the springs between them, scale with it. If it is not given and vehicle.name names a deformable vehicle, it is 0 [kg]"""
    impact__velocity: Number
    """v_c: ground speed of the vehicle, positive towards the column [m/s]"""
    impact__gap: Number
    """g_N: initial gap between vehicle and column [m]"""
    impact__restitution: Number
    """epsilon: coefficient of restitution of Newton's impact law; 0 is perfectly inelastic, 1 perfectly elastic"""
    impact__transverse_force: Number
    """F: constant force on every vehicle in its direction of travel, before, during and after contact, shared by its masses in proportion; at most 100 m/s^2 times its mass. The weight m g of a mass that falls on a horizontal member [N]"""
    impact__direction: Number
    """phi: direction of travel of the vehicle in (-pi, pi]; 0 bends the column about its strong axis, positive turns towards the positive weak-axis direction. The two bars are plane and take the component of the motion in their plane, v cos phi; the fibre beam takes all of it. A number beyond (-pi, pi] is no direction: the two bars then take the whole velocity, and there is no second opinion [rad]"""
    vehicle__name: Text
    """vehicle of impacts that name none: the paper's rigid mass, or one of the catalogue; empty: the vehicle is user-defined. If files and overrides give one of the numbers but no name, the name is empty"""
    vehicle__masses: Numbers
    """masses of a user-defined vehicle, front first, each with a spring in front of it; impact.mass scales them, and the springs between them [kg]"""
    vehicle__slack: Numbers
    """distance that closes before a spring acts, one for each spring from the second on; empty: 0 [m]"""
    vehicle__spring_1__crush: Numbers
    """spring 1, in front of mass 1: crush of the points of its force-crush curve after (0, 0), increasing [m]"""
    vehicle__spring_1__force: Numbers
    """spring 1: force at each of these points; the last slope continues behind the last point [N]"""
    vehicle__spring_1__unloading_stiffness: Number
    """spring 1: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__spring_2__crush: Numbers
    """spring 2, in front of mass 2: crush of the points of its force-crush curve after (0, 0), increasing [m]"""
    vehicle__spring_2__force: Numbers
    """spring 2: force at each of these points; the last slope continues behind the last point [N]"""
    vehicle__spring_2__unloading_stiffness: Number
    """spring 2: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__spring_3__crush: Numbers
    """spring 3, in front of mass 3: crush of the points of its force-crush curve after (0, 0), increasing [m]"""
    vehicle__spring_3__force: Numbers
    """spring 3: force at each of these points; the last slope continues behind the last point [N]"""
    vehicle__spring_3__unloading_stiffness: Number
    """spring 3: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__narrow_object: bool
    """whether the column meets half of the front's force up to a crush of 0.40 m, rising to all of it at 0.55 m, where it has reached the engine. If it is not given, it follows vehicle.name: true for cars of the catalogue, false for all others and for a user-defined vehicle. Another vehicle that an event names keeps its own default"""
    vehicle__force_factor: Number
    """factor of the forces and of the unloading stiffness of every deformable vehicle's front, for its scatter: lognormal, coefficient of variation 20 % for cars (JCSS 2.18), 40 % for lorries (assumed)"""
    vehicle__bumper_height: Number
    """height of the bumper, over which the vehicle holds the column straight; without effect where the web does not yield in shear. If it is not given, a vehicle of the catalogue has its own, and a rigid or user-defined one has 0, a force at a point [m]"""
    event__max_age: Number
    """maximum age of the stamp of an impact event; an older event is rejected, and the response to a younger one catches up [s]"""
    event__max_ahead: Number
    """how far the stamp of an impact event may lie in the future; an event further ahead is rejected [s]"""
    senders__allowed: Sequence[str]
    """who may send impact events, parameters, measurements and requests to reset, to confirm an estimate and to correct the damage; empty: everybody. An enclave is known only with DDS security; without it a GUID can be forged"""
    senders__max_rate: Number
    """impact events, sets of parameters and requests per second that the node takes from each sender, and from all new ones together; with the default, one sender that sends without end does not shorten the time that the recordings cover [1/s]"""
    senders__burst: Whole
    """number of messages that a sender may send in a burst under senders.max_rate"""
    estimation__accept: Literal["never", "confirmation", "automatic"]
    """when an impact that the sensors have detected becomes an impact of the twin. never: it is only published; confirmation: when ~/confirm_estimate accepts it; automatic: as soon as its estimate is reliable enough, at the latest with the final one"""
    estimation__momentum_width: Number
    """largest width of the 90 % interval of the momentum, relative to its mean, of an estimate that is reliable enough"""
    estimation__yield_certainty: Number
    """least probability of yielding, or of no yielding, of an estimate that is reliable enough"""
    estimation__merge_window: Number
    """largest difference of the instants of contact of an impact event and an estimate that are the same impact [s]"""
    estimation__event_mass_deviation: Number
    """relative standard deviation of the mass in an impact event that is the same impact as an estimate, by which the event counts for later estimates. 0.3: the masses of the vehicles of one kind differ by as much, because a camera or a person sees the kind and not the load [A]"""
    estimation__event_velocity_deviation: Number
    """the same for the speed in such an event. 0.15: braking between the place where a camera measures the speed and the column is not seen [A]"""
    rate__law: Literal["none", "cowper_symonds", "logarithmic"]
    """increase of the yield surface with the filtered strain rate e of each hinge. none: the paper; cowper_symonds: 1 + (e/d)^(1/q); logarithmic: 1 + c ln(e/reference), not below 1, with its defaults the form of the CEB, f_y + 6 MPa ln(e / 5e-5) (recalled, not verified)"""
    rate__d: Number
    """strain rate at which the law of Cowper and Symonds doubles the strength; 40.4 with q = 5 is for mild steel (recalled, not verified) and overstates the increase for higher grades [1/s]"""
    rate__q: Number
    """exponent of the law of Cowper and Symonds"""
    rate__c: Number
    """factor of the logarithmic law"""
    rate__reference: Number
    """strain rate below which the logarithmic law increases nothing [1/s]"""
    rate__time_constant: Number
    """time constant of the low-pass filter of the strain rate, without which the law is ill-posed [s]"""
    rate__max_factor: Number
    """largest dynamic increase factor"""
    rate__hinge_length: Number
    """length over which the rotation of a plastic hinge is spread, for its strain rate [m]"""
    shear__model: Literal["none", "web"]
    """web: the web of each bar yields in shear and deforms elastically, where its dimensions or `resistance.shear` are known; none: as in the paper, it does neither"""
    shear__max_hardening: Number
    """largest strength of a web that hardens over its initial one. If it is not given, it is f_u/f_y of `steel.grade`, or 1.1, the least of EN 1993-1-1, for user-defined steel"""
    hardening__ratio: Number
    """b: slope of the stress-strain curve after yield over Young's modulus, from first yield on; it enlarges the whole yield surface with the plastic rotation. Unless given, 0.01 for a section by name, 0.005 with a rate.law, 0 for a user-defined one; 12 measured columns need 0.006 to 0.05 (docs/theory.md). 0 is on the safe side for displacements and on the unsafe side for forces"""
    softening__model: Literal["none", "backbone"]
    """how a hinge loses strength when its flanges and web buckle locally. backbone: its moment falls with the accumulated plastic rotation beyond the capping rotation, as in a monotonic test (Lignos 2019); none: it does not. Unless given, backbone for a section by name, none for a user-defined one; with assessment.ultimate_rotation: 0 there is none"""
    softening__capping_rotation: Number
    """theta_p: plastic rotation at which the moment begins to fall, and at which hardening ends [rad]"""
    softening__post_capping_rotation: Number
    """theta_pc: further plastic rotation over which the moment would fall to zero [rad]"""
    softening__residual: Number
    """moment that remains, relative to that at the capping rotation"""
    solver__scheme: Literal["midpoint", "conserving_midpoint"]
    """midpoint: the paper's midpoint rule as printed; conserving_midpoint: the midpoint rule that conserves energy"""
    solver__dt: Number
    """time step; a chosen one is 1e-6 to 2e-5 s and keeps the error of the peak displacement below 2e-4 for 99 of 100 columns, with the largest seen at 2e-3 [s]"""
    damping__ratio: Number
    """damping ratio of the elastic modes, relative to critical damping; the paper has no damping"""
    response__duration: Number
    """maximum duration of a computed response from the end of the approach, and of the approach; a response ends earlier if the column comes to rest [s]"""
    capacity__imperfection: Number
    """e0: bow of the column for its axial capacity, at most a tenth of its height [m]"""
    capacity__buckling_factor_strong: Number
    """K_y: buckling length about the strong axis, in the plane of the impact, over the height of the column"""
    capacity__buckling_factor_weak: Number
    """K_z: buckling length about the weak axis over the height of the column; 1 for a base plate with two rows of anchors next to the web, which holds the weak axis as a pin"""
    assessment__ultimate_rotation: Number
    """theta_u: plastic rotation at which a hinge is fractured, of hinges 1a and 1b together: the response ends there, and the column is fractured (Lignos 2019) [rad]"""
    assessment__ultimate_shear_angle: Number
    """plastic shear angle at which the web of a bar is fractured: the response ends there, and the column is fractured (ASCE/SEI 41-17, links that yield in shear; recalled). `assessment.ultimate_rotation: 0` lifts this limit, too [rad]"""
    assessment__criteria: Sequence[str]
    """criteria that decide the action; all others are shown only. `collapse` always decides"""
    assessment__assumed: Sequence[str]
    """inputs of the column that nobody has given and whose defaults are assumed: the action is then a lower bound, and its range reaches `evacuate`. Unless this list is given, it holds those that are left out where column_id, section.name or section.area is given. Another value of one of them removes it from the list; to confirm the assumed value, give this list without it"""
    assessment__range_velocity: Number
    """relative range of the speed of the vehicle, to both sides, within which the action of a verdict is sought. 0.1: a speed that is read from skid marks or a camera [A]"""
    assessment__range_height: Number
    """the same for the height of the impact point. 0.2: bumpers of one kind of vehicle differ by as much, and brakes dip them [A] [m]"""
    assessment__range_front: Number
    """relative range of the force of the vehicle's front, to both sides, for the same. 0.2: the standard deviation of `vehicle.force_factor`"""
    beam__mode: Literal["off", "second_opinion", "governing"]
    """whether the fibre beam computes impacts, too: in `simulate` and nodes, and in maps and risk studies with `--model`. off: it does not, and estimates from sensors do without it, too; second_opinion: its verdict counts where the two models differ (docs/second_opinion.md lists when); governing: it always counts. The more severe action of the two models then applies"""
    beam__elements: Whole
    """elements of the fibre beam along the column; 0: automatic"""
    beam__fibres: Whole
    """layers of fibres of the web, and at least as many fibres across a flange; 0: automatic"""
    beam__dt: Number
    """time step of the fibre beam [s]"""
    beam__shear: bool
    """whether the web of the fibre beam deforms and yields in shear"""
    beam__torsion: Literal["warping", "saint_venant", "none"]
    """how the fibre beam resists twist. warping: St Venant's torsion and restrained warping; saint_venant: that torsion alone; none: the twist is suppressed"""
    beam__residual_stress: bool
    """whether the fibre beam has the residual stresses of rolling (ECCS)"""
    beam__bow: Number
    """initial bow of the fibre beam about each axis of `beam.bow_axes`, at most a twentieth of its height; 0: straight; negative: a thousandth of the height [m]"""
    beam__bow_axes: Literal["both", "strong", "weak"]
    """axes about which the fibre beam is bowed before the impact, and about which its capacity counts"""
    beam__steel: Literal["bilinear", "plateau"]
    """stress of the steel of the fibre beam over its strain. bilinear: it hardens from the first yield on, with `hardening.ratio`; plateau: it yields at the same stress at first and then hardens up to the tensile strength of `steel.grade` (EN 1993-1-14, after Yun and Gardner 2017)"""
    state__directory: Text
    """directory of the state file, which is named after the column and preserves the damage across restarts; `$XDG_STATE_HOME` is `~/.local/state` unless the environment sets it; empty: the damage is lost when the program ends"""
    real_time__priority: Whole
    """SCHED_FIFO priority of the solver thread, if the system permits it, with the publishing thread one below and the thread of DDS two below; 0: normal scheduling"""
    real_time__processors: Text
    """processors that the solver thread may run on; empty: all"""
    real_time__lock_memory: bool
    """lock the program's memory so that it is never swapped out, if the system permits it"""
    real_time__threads: Whole
    """solver threads of a fleet; 0: as many as processors. A single twin has one"""
    record__mode: Literal["off", "events", "always"]
    """off: no recording; events: every impact event with its response; always: everything"""
    record__directory: Text
    """directory of the recordings; `$XDG_STATE_HOME` as for `state.directory`"""
    record__max_file_size: Whole
    """size at which a new recording is started once the column is at rest; at twice this size in any case [B]"""
    record__max_duration: Number
    """duration after which a new recording is started once the column is at rest; after twice this duration in any case [s]"""
    record__max_files: Whole
    """maximum number of recordings, beyond which the oldest are deleted; 0: no limit"""
    record__max_total_size: Whole
    """maximum total size of all recordings, beyond which the oldest are deleted; 0: no limit [B]"""
    record__max_age: Number
    """age at which recordings are deleted [s]"""
    record__compression: Literal["none", "lz4", "zstd"]
    """compression of the chunks of recordings"""
    record__sync: bool
    """write recorded data to the disk within 50 ms, so that they survive a power failure and not only a crash of the program"""
    record__seal: bool
    """seal recordings: sign a hash chain over all messages, so that every later change is detected"""
    record__seal_key: Text
    """file of the private key of the seals, as `openssl genpkey -algorithm ed25519` writes it; empty: a fresh key for each run, which proves that nothing was changed but not who recorded"""
    viewer__mode: Literal["off", "save", "serve", "connect", "spawn"]
    """off: no pictures; save: write a file; serve: viewers connect to this program; connect: connect to a running viewer; spawn: start a viewer"""
    viewer__address: Text
    """address to serve on or to connect to"""
    viewer__port: Whole
    """TCP port to serve on or to connect to"""
    viewer__directory: Text
    """directory of the files that `save` writes; `$XDG_STATE_HOME` as for `state.directory`"""
    viewer__memory_limit: Whole
    """memory for the data that viewers receive when they connect later or again (serve, connect, spawn); the oldest data are dropped first [B]"""
    viewer__magnification: Number
    """magnification factor of the displacements in the pictures; 1: true to scale"""
    viewer__select: Sequence[str]
    """columns of a fleet that the viewer always shows in full, besides the one that was hit last: their `column_id`, or their names with the wildcards of parameter files (`/garage/*`); a single twin ignores it"""
    alarm__spool: Text
    """directory of the alarms that wait for delivery; each node needs one of its own; `$XDG_STATE_HOME` as for `state.directory`"""
    alarm__heartbeat: Number
    """time between two heartbeats, whose absence shows the receiver that the node does not run or cannot be reached [s]"""
    alarm__mqtt__broker: Text
    """broker of MQTT 5, such as mqtts://broker.example:8883; empty: no alarms by MQTT"""
    alarm__mqtt__client_id: Text
    """name by which the broker identifies the node; two nodes with the same one disconnect one another; empty: from the name of the node"""
    alarm__mqtt__topic: Text
    """template of the topics, with the fields {node}, {subject} (the column, or column/sensor) and {kind} (action, sensor_failed, node_stopped, heartbeat or test)"""
    alarm__mqtt__user: Text
    """user, if the broker asks for one"""
    alarm__mqtt__password_file: Text
    """file with the password of the user, which nobody else may read (mode 0600)"""
    alarm__mqtt__ca_file: Text
    """certificates of the authorities that are trusted (PEM); empty: the authorities of the system"""
    alarm__mqtt__certificate_file: Text
    """certificate of the node with its chain (PEM), if the broker asks for one"""
    alarm__mqtt__key_file: Text
    """private key of this certificate (PEM, mode 0600)"""
    alarm__mqtt__action: Literal["off", "inspect", "restrict", "shore", "evacuate"]
    """mildest action that is an alarm; off: none is"""
    alarm__mqtt__sensor_failed: bool
    """whether a sensor that is dead or stuck is an alarm"""
    alarm__mqtt__node_stopped: bool
    """whether it is an alarm that the node stops, in order or not"""
    alarm__webhook__url: Text
    """address that alarms are posted to, such as https://alarms.example/column; http:// for this machine only; empty: no webhook"""
    alarm__webhook__secret_file: Text
    """file with the key of the signatures: whsec_ and at least 24 bytes in Base64 (Standard Webhooks, mode 0600)"""
    alarm__webhook__ca_file: Text
    """certificates of the authorities that are trusted (PEM); empty: the authorities of the system"""
    alarm__webhook__certificate_file: Text
    """certificate of the node with its chain (PEM), if the receiver asks for one"""
    alarm__webhook__key_file: Text
    """private key of this certificate (PEM, mode 0600)"""
    alarm__webhook__action: Literal["off", "inspect", "restrict", "shore", "evacuate"]
    """mildest action that is an alarm; off: none is"""
    alarm__webhook__sensor_failed: bool
    """whether a sensor that is dead or stuck is an alarm"""
    alarm__webhook__node_stopped: bool
    """whether it is an alarm that the node stops, in order or not"""
    metrics__address: Text
    """address and port from which Prometheus reads, such as 127.0.0.1:9464; empty: no metrics"""
    foxglove__mode: Literal["off", "serve"]
    """off: no live topics for Foxglove; serve: Foxglove connects to this program, past DDS and its security"""
    foxglove__address: Text
    """address and port to serve on; everybody who reaches an address that is not loopback sees the topics"""
    foxglove__origins: Sequence[str]
    """web pages that may connect, by their origins; programs, which send no origin, and pages of this machine always may"""
    foxglove__control: bool
    """whether Foxglove may set parameters and reset columns; `senders.*` does not limit it"""
    sensors__names: Sequence[str]
    """names of the sensors on the column, which the names of their parameters contain"""



class AxisKeywords(TypedDict, total=False):
    """An axis of a map."""

    mass: AxisNumbers
    """total mass of the vehicle [kg]"""
    velocity: AxisNumbers
    """speed of the vehicle [m/s]"""
    height: AxisNumbers
    """height of the impact point above the base [m]; the height of the column remains"""
    direction: AxisNumbers
    """direction of travel of the vehicle [rad], above -pi to pi; 0 bends the column about its strong axis. A text is in degrees, as on the command line"""
    section: AxisNames
    """sections of the catalogue"""
    publish_rate: AxisNumbers
    """rate at which state and hinge forces are published during a response; at most once per step, with the period rounded to whole steps [Hz]"""
    site__x: AxisNumbers
    """position of the column in the plan of its fleet, to the right; columns of a fleet that share a position with another one, or give none, are shown in rows below the plan [m]"""
    site__y: AxisNumbers
    """position of the column in the plan of its fleet, upwards in the picture; see `site.x` [m]"""
    geometry__height: AxisNumbers
    """height of the column. With it, the impact point is where the vehicle strikes (`column-twin vehicles` lists the heights: cars 0.5 m, forklift trucks 0.75 m, lorries 1.25 m), unless `geometry.length_below` or the impact gives a height, and `geometry.length_above` is the rest. Both lengths replace it where they are given later: in a later file or section, on the command line, or by a change of both together [m]"""
    geometry__length_below: AxisNumbers
    """L_a: height of the impact point above the base [m]"""
    geometry__length_above: AxisNumbers
    """L_b: distance from the impact point to the top [m]"""
    section__area: AxisNumbers
    """A: cross-sectional area; overrides the area of a named section [m^2]"""
    section__second_moment: AxisNumbers
    """I: second moment of area; overrides the value of a named section [m^4]"""
    section__mass_per_length: AxisNumbers
    """m_l: mass per length; overrides the value of a named section [kg/m]"""
    section__height: AxisNumbers
    """h: height in the plane of bending, for strain rates; overrides the value of a named section [m]"""
    section__width: AxisNumbers
    """b: width of the flanges, for the shear of the web; overrides the value of a named section [m]"""
    section__web_thickness: AxisNumbers
    """t_w: thickness of the web, for its shear; overrides the value of a named section. A user-defined section yields in shear if it has this and `section.height` [m]"""
    section__flange_thickness: AxisNumbers
    """t_f: thickness of the flanges, for the shear of the web; overrides the value of a named section [m]"""
    steel__young_modulus: AxisNumbers
    """E: Young's modulus; overrides the value of a named grade [Pa]"""
    steel__yield_strength: AxisNumbers
    """f_y: yield strength; overrides the value of a named grade [Pa]"""
    resistance__moment: AxisNumbers
    """M^p: plastic moment resistance without normal force [N m]"""
    resistance__axial: AxisNumbers
    """N^p: plastic axial resistance (squash load) [N]"""
    resistance__shear: AxisNumbers
    """V_s: plastic resistance of a bar against shear, all of it [N]"""
    yield_surface__alpha: AxisNumbers
    """alpha: exponent of the moment (Eq 28); 1 with beta = 1.3 is Duan-Chen, 2 with beta = 2 an ellipse"""
    yield_surface__beta: AxisNumbers
    """beta: exponent of the normal force (Eq 28)"""
    yield_surface__gamma: AxisNumbers
    """gamma: the whole sum is raised to 1/gamma (Eq 28), which scales the plastic multiplier but not the surface"""
    hinge__stiffness_1a: AxisNumbers
    """rotational stiffness of hinge 1a, below the impact point; only with the uncoupled law [N m/rad]"""
    hinge__stiffness_1b: AxisNumbers
    """rotational stiffness of hinge 1b, above the impact point; only with the uncoupled law [N m/rad]"""
    hinge__stiffness_2: AxisNumbers
    """rotational stiffness of hinge 2, at the top; only with the uncoupled law and a built-in top [N m/rad]"""
    hinge__stiffness_3: AxisNumbers
    """rotational stiffness of hinge 3, at the base; only with the uncoupled law and a built-in base [N m/rad]"""
    support__base_stiffness: AxisNumbers
    """rotational stiffness of a semi-rigid base [N m/rad]"""
    support__top_stiffness: AxisNumbers
    """rotational stiffness of a semi-rigid top [N m/rad]"""
    base__plate_thickness: AxisNumbers
    """t_p: thickness of the base plate [m]"""
    base__plate_length: AxisNumbers
    """length of the base plate in the plane of bending, parallel to the web [m]"""
    base__plate_width: AxisNumbers
    """width of the base plate, parallel to the flanges [m]"""
    base__anchor_count: AxisNumbers
    """number of anchors in two lines parallel to the flanges, half of them in each; even; 0 without a plate"""
    base__anchor_diameter: AxisNumbers
    """nominal diameter of the anchors, a thread of the coarse series such as 0.024 [m]"""
    base__anchor_distance: AxisNumbers
    """z_T: distance of each line of anchors from the axis of the section [m]"""
    base__friction: AxisNumbers
    """C_f: coefficient of friction between plate and grout; 0.2 for sand and cement (EN 1993-1-8, 6.2.2)"""
    top__spring_stiffness: AxisNumbers
    """k_s: stiffness of the vertical spring at the top, which represents the rest of the structure and takes load off a column that shortens. Unless given, 0 for a section by name, 1e7 (the paper's example) for a user-defined one [N/m]"""
    top__mass: AxisNumbers
    """m_2: lumped mass at the top [kg]"""
    top__load: AxisNumbers
    """P: constant vertical load at the top, positive in compression [N]"""
    top__redistribution_limit: AxisNumbers
    """largest force that the structure above is proven to take off the column. The verdict compares with top.load less the force that the spring takes, at most this; needs top.redistribution_proof and a top.spring_stiffness. The response has the whole spring in any case [N]"""
    impact__mass: AxisNumbers
    """m_c: total mass of the vehicle; all masses of a deformable one, and the springs between them, scale with it. If it is not given and vehicle.name names a deformable vehicle, it is 0 [kg]"""
    impact__velocity: AxisNumbers
    """v_c: ground speed of the vehicle, positive towards the column [m/s]"""
    impact__gap: AxisNumbers
    """g_N: initial gap between vehicle and column [m]"""
    impact__restitution: AxisNumbers
    """epsilon: coefficient of restitution of Newton's impact law; 0 is perfectly inelastic, 1 perfectly elastic"""
    impact__transverse_force: AxisNumbers
    """F: constant force on every vehicle in its direction of travel, before, during and after contact, shared by its masses in proportion; at most 100 m/s^2 times its mass. The weight m g of a mass that falls on a horizontal member [N]"""
    impact__direction: AxisNumbers
    """phi: direction of travel of the vehicle in (-pi, pi]; 0 bends the column about its strong axis, positive turns towards the positive weak-axis direction. The two bars are plane and take the component of the motion in their plane, v cos phi; the fibre beam takes all of it. A number beyond (-pi, pi] is no direction: the two bars then take the whole velocity, and there is no second opinion [rad]"""
    vehicle__spring_1__unloading_stiffness: AxisNumbers
    """spring 1: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__spring_2__unloading_stiffness: AxisNumbers
    """spring 2: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__spring_3__unloading_stiffness: AxisNumbers
    """spring 3: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic [N/m]"""
    vehicle__force_factor: AxisNumbers
    """factor of the forces and of the unloading stiffness of every deformable vehicle's front, for its scatter: lognormal, coefficient of variation 20 % for cars (JCSS 2.18), 40 % for lorries (assumed)"""
    vehicle__bumper_height: AxisNumbers
    """height of the bumper, over which the vehicle holds the column straight; without effect where the web does not yield in shear. If it is not given, a vehicle of the catalogue has its own, and a rigid or user-defined one has 0, a force at a point [m]"""
    event__max_age: AxisNumbers
    """maximum age of the stamp of an impact event; an older event is rejected, and the response to a younger one catches up [s]"""
    event__max_ahead: AxisNumbers
    """how far the stamp of an impact event may lie in the future; an event further ahead is rejected [s]"""
    senders__max_rate: AxisNumbers
    """impact events, sets of parameters and requests per second that the node takes from each sender, and from all new ones together; with the default, one sender that sends without end does not shorten the time that the recordings cover [1/s]"""
    senders__burst: AxisNumbers
    """number of messages that a sender may send in a burst under senders.max_rate"""
    estimation__momentum_width: AxisNumbers
    """largest width of the 90 % interval of the momentum, relative to its mean, of an estimate that is reliable enough"""
    estimation__yield_certainty: AxisNumbers
    """least probability of yielding, or of no yielding, of an estimate that is reliable enough"""
    estimation__merge_window: AxisNumbers
    """largest difference of the instants of contact of an impact event and an estimate that are the same impact [s]"""
    estimation__event_mass_deviation: AxisNumbers
    """relative standard deviation of the mass in an impact event that is the same impact as an estimate, by which the event counts for later estimates. 0.3: the masses of the vehicles of one kind differ by as much, because a camera or a person sees the kind and not the load [A]"""
    estimation__event_velocity_deviation: AxisNumbers
    """the same for the speed in such an event. 0.15: braking between the place where a camera measures the speed and the column is not seen [A]"""
    rate__d: AxisNumbers
    """strain rate at which the law of Cowper and Symonds doubles the strength; 40.4 with q = 5 is for mild steel (recalled, not verified) and overstates the increase for higher grades [1/s]"""
    rate__q: AxisNumbers
    """exponent of the law of Cowper and Symonds"""
    rate__c: AxisNumbers
    """factor of the logarithmic law"""
    rate__reference: AxisNumbers
    """strain rate below which the logarithmic law increases nothing [1/s]"""
    rate__time_constant: AxisNumbers
    """time constant of the low-pass filter of the strain rate, without which the law is ill-posed [s]"""
    rate__max_factor: AxisNumbers
    """largest dynamic increase factor"""
    rate__hinge_length: AxisNumbers
    """length over which the rotation of a plastic hinge is spread, for its strain rate [m]"""
    shear__max_hardening: AxisNumbers
    """largest strength of a web that hardens over its initial one. If it is not given, it is f_u/f_y of `steel.grade`, or 1.1, the least of EN 1993-1-1, for user-defined steel"""
    hardening__ratio: AxisNumbers
    """b: slope of the stress-strain curve after yield over Young's modulus, from first yield on; it enlarges the whole yield surface with the plastic rotation. Unless given, 0.01 for a section by name, 0.005 with a rate.law, 0 for a user-defined one; 12 measured columns need 0.006 to 0.05 (docs/theory.md). 0 is on the safe side for displacements and on the unsafe side for forces"""
    softening__capping_rotation: AxisNumbers
    """theta_p: plastic rotation at which the moment begins to fall, and at which hardening ends [rad]"""
    softening__post_capping_rotation: AxisNumbers
    """theta_pc: further plastic rotation over which the moment would fall to zero [rad]"""
    softening__residual: AxisNumbers
    """moment that remains, relative to that at the capping rotation"""
    solver__dt: AxisNumbers
    """time step; a chosen one is 1e-6 to 2e-5 s and keeps the error of the peak displacement below 2e-4 for 99 of 100 columns, with the largest seen at 2e-3 [s]"""
    damping__ratio: AxisNumbers
    """damping ratio of the elastic modes, relative to critical damping; the paper has no damping"""
    response__duration: AxisNumbers
    """maximum duration of a computed response from the end of the approach, and of the approach; a response ends earlier if the column comes to rest [s]"""
    capacity__imperfection: AxisNumbers
    """e0: bow of the column for its axial capacity, at most a tenth of its height [m]"""
    capacity__buckling_factor_strong: AxisNumbers
    """K_y: buckling length about the strong axis, in the plane of the impact, over the height of the column"""
    capacity__buckling_factor_weak: AxisNumbers
    """K_z: buckling length about the weak axis over the height of the column; 1 for a base plate with two rows of anchors next to the web, which holds the weak axis as a pin"""
    assessment__ultimate_rotation: AxisNumbers
    """theta_u: plastic rotation at which a hinge is fractured, of hinges 1a and 1b together: the response ends there, and the column is fractured (Lignos 2019) [rad]"""
    assessment__ultimate_shear_angle: AxisNumbers
    """plastic shear angle at which the web of a bar is fractured: the response ends there, and the column is fractured (ASCE/SEI 41-17, links that yield in shear; recalled). `assessment.ultimate_rotation: 0` lifts this limit, too [rad]"""
    assessment__range_velocity: AxisNumbers
    """relative range of the speed of the vehicle, to both sides, within which the action of a verdict is sought. 0.1: a speed that is read from skid marks or a camera [A]"""
    assessment__range_height: AxisNumbers
    """the same for the height of the impact point. 0.2: bumpers of one kind of vehicle differ by as much, and brakes dip them [A] [m]"""
    assessment__range_front: AxisNumbers
    """relative range of the force of the vehicle's front, to both sides, for the same. 0.2: the standard deviation of `vehicle.force_factor`"""
    beam__elements: AxisNumbers
    """elements of the fibre beam along the column; 0: automatic"""
    beam__fibres: AxisNumbers
    """layers of fibres of the web, and at least as many fibres across a flange; 0: automatic"""
    beam__dt: AxisNumbers
    """time step of the fibre beam [s]"""
    beam__bow: AxisNumbers
    """initial bow of the fibre beam about each axis of `beam.bow_axes`, at most a twentieth of its height; 0: straight; negative: a thousandth of the height [m]"""
    real_time__priority: AxisNumbers
    """SCHED_FIFO priority of the solver thread, if the system permits it, with the publishing thread one below and the thread of DDS two below; 0: normal scheduling"""
    real_time__threads: AxisNumbers
    """solver threads of a fleet; 0: as many as processors. A single twin has one"""
    record__max_file_size: AxisNumbers
    """size at which a new recording is started once the column is at rest; at twice this size in any case [B]"""
    record__max_duration: AxisNumbers
    """duration after which a new recording is started once the column is at rest; after twice this duration in any case [s]"""
    record__max_files: AxisNumbers
    """maximum number of recordings, beyond which the oldest are deleted; 0: no limit"""
    record__max_total_size: AxisNumbers
    """maximum total size of all recordings, beyond which the oldest are deleted; 0: no limit [B]"""
    record__max_age: AxisNumbers
    """age at which recordings are deleted [s]"""
    viewer__port: AxisNumbers
    """TCP port to serve on or to connect to"""
    viewer__memory_limit: AxisNumbers
    """memory for the data that viewers receive when they connect later or again (serve, connect, spawn); the oldest data are dropped first [B]"""
    viewer__magnification: AxisNumbers
    """magnification factor of the displacements in the pictures; 1: true to scale"""
    alarm__heartbeat: AxisNumbers
    """time between two heartbeats, whose absence shows the receiver that the node does not run or cannot be reached [s]"""
