// Names of effects, and of the components that have them, in the page's language; English ones are those of the service's `says`.

import { t } from "./language.js";

const EFFECTS = {
  wheel_diameter: t("wheel_diameter"), wheel_eccentricity: t("wheel_eccentricity"), radius_vs_speed: t("radius_vs_speed"), radius_step: t("radius_step"),
  bump: t("bump"), slip_patch: t("slip_patch"), traction_slip: t("traction_slip"), count_loss: t("count_loss"),
  gear_backlash: t("gear_backlash"), gear_harmonic: t("gear_harmonic"),
  wheelbase: t("wheelbase"), turn_scrub: t("turn_scrub"), wheel_misalignment: t("wheel_misalignment"), lateral_slip: t("lateral_slip"),
  floor_slope: t("floor_slope"), castor_kick: t("castor_kick"), reference_offset: t("reference_offset"),
  joint_bias: t("joint_bias"), joint_eccentricity: t("joint_eccentricity"), joint_backlash: t("joint_backlash"),
  link_bias: t("link_bias"), link_eccentricity: t("link_eccentricity"), link_scale: t("link_scale"),
  latency: t("latency"), clock_drift: t("clock_drift"), law: t("law"), unknown: t("unknown"),
};
const COMPONENTS = {
  "a.left": t("a.left"), "a.right": t("a.right"), "b.left": t("b.left"), "b.right": t("b.right"), a: t("a"), b: t("b"),
  left: t("left"), right: t("right"), joint_a: t("joint_a"), joint_b: t("joint_b"), link: t("link"), poses: t("poses"),
};

/** The name of an effect; one that this page does not know stays as it is. */
export const effectName = (effect) => EFFECTS[effect] ?? effect;

/** The name of a component, as `effectName`. */
export const componentName = (component) => COMPONENTS[component] ?? component;
