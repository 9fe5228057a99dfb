//! The parameters as typed data, grouped as their names are.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::assumed::AssumedInput;
use super::qos_overrides::QosSettings;
use crate::column::{ElasticLaw, HINGES, Scheme};

/// Every parameter by its name in the [table](super::PARAMETERS), which also gives units and meaning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // documented once, in the table
pub struct Settings {
    pub column_id: String,
    pub frame_id: String,
    // Absent in recordings and states of programs that do not show fleets.
    #[serde(default)]
    pub site: SiteSettings,
    pub geometry: GeometrySettings,
    pub section: SectionSettings,
    pub steel: SteelSettings,
    pub resistance: ResistanceSettings,
    pub yield_surface: YieldSurfaceSettings,
    pub hinge: HingeSettings,
    pub support: SupportSettings,
    // Absent in recordings and states of programs that know no connections.
    #[serde(default)]
    pub base: BaseSettings,
    pub top: TopSettings,
    /// Default impact, for what an impact event leaves open.
    pub impact: ImpactSettings,
    /// The vehicle of an impact that names none.
    pub vehicle: VehicleSettings,
    pub event: EventSettings,
    pub senders: SendersSettings,
    pub estimation: EstimationSettings,
    pub rate: RateSettings,
    pub shear: ShearSettings,
    pub hardening: HardeningSettings,
    // Absent in recordings and states of programs whose hinges do not soften.
    #[serde(default)]
    pub softening: SofteningSettings,
    pub solver: SolverSettings,
    pub damping: DampingSettings,
    pub response: ResponseSettings,
    pub capacity: CapacitySettings,
    pub assessment: AssessmentSettings,
    // Left out where nothing differs from the defaults, as in the recordings and states of programs that know no beam.
    #[serde(default, skip_serializing_if = "is_default")]
    pub beam: BeamSettings,
    pub state: StateSettings,
    pub publish_rate: f64,
    pub use_sim_time: bool,
    pub start_type_description_service: bool,
    pub real_time: RealTimeSettings,
    pub record: RecordSettings,
    pub viewer: ViewerSettings,
    // Left out where nothing differs from the defaults, as in the recordings and states of programs that know no alarms.
    #[serde(default, skip_serializing_if = "is_default")]
    pub alarm: AlarmSettings,
    #[serde(default, skip_serializing_if = "is_default")]
    pub metrics: MetricsSettings,
    #[serde(default, skip_serializing_if = "is_default")]
    pub foxglove: FoxgloveSettings,
    // Left out where there are none, as in the recordings and states of programs that know no sensors.
    #[serde(default, skip_serializing_if = "SensorsSettings::is_empty")]
    pub sensors: SensorsSettings,
    // Of the node and its network, not of the column: no recording and no state needs them.
    #[serde(skip)]
    pub qos_overrides: QosSettings,
}

/// The sensors on the column as given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorsSettings {
    /// Their names, in the order given.
    pub names: Vec<String>,
    /// What is given for each name.
    #[serde(flatten)]
    pub each: BTreeMap<String, SensorSettings>,
}

macro_rules! groups {
    ($($(#[$meaning:meta])* $group:ident { $($(#[$of_field:meta])* $field:ident: $type:ty),* $(,)? })*) => {$(
        $(#[$meaning])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(missing_docs)] // documented once, in the table
        pub struct $group { $($(#[$of_field])* pub $field: $type),* }
    )*};
}

groups! {
    /// Position in the plan of a fleet.
    #[derive(Copy, Default)]
    SiteSettings { x: f64, y: f64 }
    /// Height of the column and lengths of its two bars.
    GeometrySettings {
        // Absent in recordings and states of programs that know the lengths alone.
        #[serde(default)]
        height: f64,
        length_below: f64,
        length_above: f64,
    }
    /// The section as given: a name, numbers that override its properties, or numbers alone.
    SectionSettings {
        name: String,
        area: f64,
        second_moment: f64,
        mass_per_length: f64,
        height: f64,
        width: f64,
        web_thickness: f64,
        flange_thickness: f64,
        // Left out for an I or H section, as in the recordings and states of programs that know no others.
        #[serde(default, skip_serializing_if = "is_default")]
        shape: SectionShape,
    }
    /// The steel as given: a grade, numbers that override its properties, or numbers alone.
    SteelSettings { grade: String, young_modulus: f64, yield_strength: f64 }
    /// Resistances as given; 0: computed.
    ResistanceSettings { moment: f64, axial: f64, shear: f64 }
    /// Exponents of Eq 28.
    YieldSurfaceSettings { alpha: f64, beta: f64, gamma: f64 }
    /// Elastic law of the hinges.
    HingeSettings { elastic_law: ElasticLaw, stiffness_1a: f64, stiffness_1b: f64, stiffness_2: f64, stiffness_3: f64 }
    /// Rotational supports.
    SupportSettings { base: SupportKind, base_stiffness: f64, top: SupportKind, top_stiffness: f64 }
    /// The connection of the base.
    BaseSettings {
        connection: BaseConnection,
        plate_thickness: f64,
        plate_length: f64,
        plate_width: f64,
        anchor_count: u32,
        anchor_diameter: f64,
        anchor_grade: String,
        anchor_distance: f64,
        concrete: String,
        friction: f64,
    }
    /// The structure above the column.
    TopSettings {
        spring_stiffness: f64,
        mass: f64,
        load: f64,
        // Absent in recordings and states of programs whose verdicts know the load after shedding alone.
        #[serde(default)]
        redistribution_limit: f64,
        #[serde(default)]
        redistribution_proof: String,
        #[serde(default)]
        load_basis: LoadBasis,
    }
    /// The default impact.
    ImpactSettings {
        mass: f64,
        velocity: f64,
        gap: f64,
        restitution: f64,
        // Absent in recordings and states of programs that know no such force.
        #[serde(default)]
        transverse_force: f64,
        // Left out where it is 0, as in the recordings and states of programs that know no directions.
        #[serde(default, skip_serializing_if = "is_default")]
        direction: f64,
    }
    /// The vehicle as given: a name, or numbers alone.
    VehicleSettings {
        name: String,
        masses: Vec<f64>,
        slack: Vec<f64>,
        spring_1: SpringSettings,
        spring_2: SpringSettings,
        spring_3: SpringSettings,
        narrow_object: bool,
        force_factor: f64,
        bumper_height: f64,
    }
    /// One spring of a vehicle that is given by numbers.
    SpringSettings { crush: Vec<f64>, force: Vec<f64>, unloading_stiffness: f64 }
    /// Increase of the yield surface with the strain rate.
    RateSettings {
        law: RateLawKind,
        d: f64,
        q: f64,
        c: f64,
        reference: f64,
        time_constant: f64,
        max_factor: f64,
        hinge_length: f64,
    }
    /// Shear of the web.
    ShearSettings { model: ShearModel, max_hardening: f64 }
    /// Hardening of the steel.
    HardeningSettings { ratio: f64 }
    /// Softening of the hinges as given; 0: from the section.
    #[derive(Copy, Default)]
    SofteningSettings {
        model: SofteningModel,
        capping_rotation: f64,
        post_capping_rotation: f64,
        residual: f64,
    }
    /// Admissible stamps of impact events.
    EventSettings { max_age: f64, max_ahead: f64 }
    /// Who may send events, parameters and resets, and how often.
    SendersSettings { allowed: Vec<String>, max_rate: f64, burst: u32 }
    /// When estimates from sensors become impacts.
    EstimationSettings {
        accept: AcceptEstimates,
        momentum_width: f64,
        yield_certainty: f64,
        merge_window: f64,
        event_mass_deviation: f64,
        event_velocity_deviation: f64,
    }
    /// Time stepping.
    SolverSettings { scheme: Scheme, dt: f64 }
    /// Damping of the elastic modes.
    DampingSettings { ratio: f64 }
    /// Duration of a response.
    ResponseSettings { duration: f64 }
    /// Residual axial capacity.
    CapacitySettings {
        imperfection: f64,
        // Absent in recordings and states of programs that take the buckling lengths from the supports.
        #[serde(default)]
        buckling_factor_strong: f64,
        #[serde(default)]
        buckling_factor_weak: f64,
    }
    /// Assessment of an impact.
    AssessmentSettings {
        ultimate_rotation: f64,
        ultimate_shear_angle: f64,
        criteria: Vec<String>,
        // Left out where nothing is assumed, as in the recordings and states of programs that do not tell.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        assumed: Vec<AssumedInput>,
        // The ranges are absent in recordings and states of programs that give one verdict alone.
        #[serde(default)]
        range_velocity: f64,
        #[serde(default)]
        range_height: f64,
        #[serde(default)]
        range_front: f64,
    }
    /// The fibre beam, the second opinion.
    #[derive(Copy)]
    BeamSettings {
        mode: BeamMode,
        elements: u16,
        fibres: u16,
        dt: f64,
        shear: bool,
        torsion: TorsionModel,
        residual_stress: bool,
        bow: f64,
        bow_axes: BowAxes,
        // Left out for bilinear steel, as in the recordings and states of programs whose beam knows no other.
        #[serde(default, skip_serializing_if = "is_default")]
        steel: BeamSteel,
    }
    /// The file that preserves the damage across restarts.
    StateSettings { directory: String }
    /// What the solver thread requests from the system.
    RealTimeSettings {
        priority: u8,
        processors: String,
        lock_memory: bool,
        // Absent in recordings and states of programs that know no fleets.
        #[serde(default)]
        threads: u8,
    }
    /// Recordings.
    RecordSettings {
        mode: RecordMode,
        directory: String,
        max_file_size: u64,
        max_duration: f64,
        max_files: u64,
        max_total_size: u64,
        max_age: f64,
        compression: Compression,
        sync: bool,
        seal: bool,
        seal_key: String,
    }
    /// Pictures.
    ViewerSettings {
        mode: ViewerMode,
        address: String,
        port: u16,
        directory: String,
        memory_limit: u64,
        magnification: f64,
        // Absent in recordings and states of programs that do not show fleets.
        #[serde(default)]
        select: Vec<String>,
    }
    /// Alarms that arrive.
    AlarmSettings {
        spool: String,
        heartbeat: f64,
        mqtt: AlarmMqttSettings,
        webhook: AlarmWebhookSettings,
    }
    /// Alarms by MQTT.
    AlarmMqttSettings {
        broker: String,
        client_id: String,
        topic: String,
        user: String,
        password_file: String,
        ca_file: String,
        certificate_file: String,
        key_file: String,
        action: AlarmAction,
        sensor_failed: bool,
        node_stopped: bool,
    }
    /// Alarms by webhook.
    AlarmWebhookSettings {
        url: String,
        secret_file: String,
        ca_file: String,
        certificate_file: String,
        key_file: String,
        action: AlarmAction,
        sensor_failed: bool,
        node_stopped: bool,
    }
    /// Metrics for Prometheus.
    MetricsSettings { address: String }
    /// Live topics for Foxglove.
    FoxgloveSettings {
        mode: FoxgloveMode,
        address: String,
        origins: Vec<String>,
        control: bool,
    }
    /// One sensor.
    SensorSettings {
        quantity: String,
        height: f64,
        range: f64,
        noise: f64,
        bias: f64,
        gain_error: f64,
        rate: f64,
        bandwidth: f64,
        sign: i8,
        fibre: f64,
        topic: String,
        message: SensorMessage,
        axis: SensorAxis,
    }
}

macro_rules! words {
    ($($(#[$meaning:meta])* $name:ident { $($(#[$variant_meaning:meta])* $variant:ident),* $(,)? })*) => {$(
        $(#[$meaning])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$variant_meaning])* $variant),* }
    )*};
}

words! {
    /// Rotational support of an end, without its stiffness.
    SupportKind {
        /// No rotation.
        BuiltIn,
        /// No moment.
        Pinned,
        /// A spring.
        SemiRigid,
        /// Of the top only: nothing.
        Free,
    }
    /// Which load the load at the top is.
    #[derive(Default)]
    LoadBasis {
        /// The one that the column carries now.
        #[default]
        Present,
        /// The accidental combination of EN 1990.
        Accidental,
    }
    /// Whether the web of the column yields in shear.
    ShearModel {
        /// It neither yields nor deforms, as in the paper.
        None,
        /// A plastic slider in each bar.
        Web,
    }
    /// What the verdict of the fibre beam counts.
    BeamMode {
        /// It is not computed.
        Off,
        /// It counts where both models part.
        SecondOpinion,
        /// It always counts.
        Governing,
    }
    /// How the fibre beam resists twist.
    TorsionModel {
        /// St Venant's torsion and restrained warping.
        Warping,
        /// St Venant's torsion alone.
        SaintVenant,
        /// The twist is suppressed.
        None,
    }
    /// Shape of a section by numbers.
    #[derive(Default)]
    SectionShape {
        /// Flanges and a web.
        #[default]
        IOrH,
        /// Four walls.
        RectangularHollow,
        /// A tube.
        CircularHollow,
    }
    /// Stress of the steel of the fibre beam over its strain.
    #[derive(Default)]
    BeamSteel {
        /// Two straight lines.
        #[default]
        Bilinear,
        /// A yield plateau, then hardening up to the tensile strength.
        Plateau,
    }
    /// Axes about which the fibre beam is bowed.
    BowAxes {
        /// Both.
        Both,
        /// The strong axis.
        Strong,
        /// The weak axis.
        Weak,
    }
    /// Connection of the base.
    BaseConnection {
        /// Nothing is known of it.
        None,
        /// A plate with anchors.
        Plate,
    }
    /// Form of the dynamic increase factor, without its numbers.
    RateLawKind {
        /// No increase.
        None,
        /// Of Cowper and Symonds.
        CowperSymonds,
        /// Of the CEB.
        Logarithmic,
    }
    /// How hinges lose strength.
    #[derive(Default)]
    SofteningModel {
        /// They do not.
        #[default]
        None,
        /// After a capping rotation.
        Backbone,
    }
    /// When an estimate becomes an impact.
    AcceptEstimates {
        /// It is only published.
        Never,
        /// When somebody confirms it.
        Confirmation,
        /// As soon as it is sure enough.
        Automatic,
    }
    /// What is recorded.
    RecordMode {
        /// Nothing.
        Off,
        /// Every event with its response.
        Events,
        /// Everything.
        Always,
    }
    /// Compression of the chunks of a recording.
    Compression {
        /// None.
        None,
        /// Fast.
        Lz4,
        /// Small.
        Zstd,
    }
    /// Type of the messages of a sensor.
    SensorMessage {
        /// `column_twin_msgs/msg/Measurement`.
        Measurement,
        /// `sensor_msgs/msg/Imu`.
        Imu,
        /// `geometry_msgs/msg/AccelStamped`.
        AccelStamped,
    }
    /// Component of a vector.
    SensorAxis {
        /// The first one.
        X,
        /// The second one.
        Y,
        /// The third one.
        Z,
    }
    /// Whether Foxglove can connect.
    FoxgloveMode {
        /// It cannot.
        Off,
        /// It connects to this program.
        Serve,
    }
    /// The mildest action that is an alarm.
    AlarmAction {
        /// None is.
        Off,
        /// To inspect the column.
        Inspect,
        /// To keep people and loads away.
        Restrict,
        /// To take the load off.
        Shore,
        /// To leave the building.
        Evacuate,
    }
    /// Destination of the pictures.
    ViewerMode {
        /// No pictures.
        Off,
        /// A file.
        Save,
        /// Viewers that connect to this program.
        Serve,
        /// A viewer that is running.
        Connect,
        /// A viewer that this program starts.
        Spawn,
    }
}

/// For what is left out where it has its default.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl HingeSettings {
    /// The stiffnesses as given \[N m/rad\], each with the name of its parameter, in the order of [`HINGE_NAMES`].
    ///
    /// [`HINGE_NAMES`]: crate::column::HINGE_NAMES
    #[must_use]
    pub fn stiffnesses(&self) -> [(&'static str, f64); HINGES] {
        [
            ("hinge.stiffness_1a", self.stiffness_1a),
            ("hinge.stiffness_1b", self.stiffness_1b),
            ("hinge.stiffness_2", self.stiffness_2),
            ("hinge.stiffness_3", self.stiffness_3),
        ]
    }
}

impl LoadBasis {
    /// Which load it is, as part of a sentence.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Present => "the present load",
            Self::Accidental => "the accidental combination of EN 1990 with its psi factors",
        }
    }
}

impl SensorsSettings {
    fn is_empty(&self) -> bool {
        self.names.is_empty() && self.each.is_empty()
    }
}

impl SensorMessage {
    /// Its word in parameters.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Measurement => "measurement",
            Self::Imu => "imu",
            Self::AccelStamped => "accel_stamped",
        }
    }
}
