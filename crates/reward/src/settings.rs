//! The settings of a reward: the table `reward` of an experiment file.

use config::{Section, at_least, within};
use serde::Serialize;

use super::{extrinsic::ExtrinsicSettings, intrinsic::IntrinsicSettings, mix::MixSettings};

/// What a reward is made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RewardSettings {
    /// A last factor of r, penalty and all; 1.
    pub scale: f64,
    /// Subtracted from the mix for each penalised part that touches something, before `scale`; 1 %
    /// of the mix's nominal maximum.
    pub penalty: f64,
    /// The task's part of the reward.
    pub extrinsic: ExtrinsicSettings,
    /// The information's part of the reward.
    pub intrinsic: IntrinsicSettings,
    /// The rule that makes one number of both.
    pub mix: MixSettings,
}

impl Default for RewardSettings {
    fn default() -> Self {
        let mix = MixSettings::default();
        Self {
            scale: 1.0,
            penalty: mix.get().one_percent(),
            extrinsic: ExtrinsicSettings::default(),
            intrinsic: IntrinsicSettings::default(),
            mix,
        }
    }
}

impl RewardSettings {
    /// Reads the table.
    pub fn read(section: &mut Section<'_>) -> Option<Self> {
        let extrinsic = section.table_or_empty("extrinsic", ExtrinsicSettings::read);
        let intrinsic = section.table_or_empty("intrinsic", IntrinsicSettings::read);
        let mix = section.table_or_empty("mix", |section| {
            let mix = MixSettings::read(section)?;
            if matches!(intrinsic, Some(IntrinsicSettings::None(_))) {
                require_xi_of_one(section, &mix);
            }
            Some(mix)
        });
        let one_percent = mix.as_ref().map_or(0.0, |mix| mix.get().one_percent());
        Some(Self {
            scale: section.or("scale", within(1e-50, 1e50), 1.0),
            penalty: section.or("penalty", at_least(0.0), one_percent),
            extrinsic: extrinsic?,
            intrinsic: intrinsic?,
            mix: mix?,
        })
    }
}

/// With any other xi, a geometric mix with nothing is always 0, and nothing is ever learned.
fn require_xi_of_one(section: &Section<'_>, mix: &MixSettings) {
    let xi = mix.get().xi();
    if xi.points().any(|(_, xi)| xi != 1.0) {
        let (key, one) = match section.has("schedule") {
            true => ("schedule", "1 throughout"),
            false => ("xi", "1"),
        };
        section.refuse(key, &format!("{one} where reward.intrinsic.kind is \"none\""), xi);
    }
}
