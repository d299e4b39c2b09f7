//! The settings of a reward: the table `reward` of an experiment file.

use config::{Rule, Section, at_least, within};
use serde::Serialize;

use super::{extrinsic::ExtrinsicSettings, intrinsic::IntrinsicSettings, mix::MixSettings};

/// What a reward is made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RewardSettings {
    /// A last factor of r, penalty and all.
    pub scale: f64,
    /// Subtracted from the mix for each penalised part that touches something, before `scale`.
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
        let scale = within(1e-50, 1e50)
            .about("a last factor of r, penalty and all: changes nothing but the scale");
        let penalty = at_least(0.0).about(
            "for each penalised part that touches something, in units of the mix; by default 1 % of \
             the mix's nominal maximum, 0.01 * 0.1^power: 0.001 for power 1 and the linear mix",
        );
        Some(Self {
            scale: section.or("scale", scale, Self::default().scale),
            penalty: section.or("penalty", penalty, one_percent),
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
