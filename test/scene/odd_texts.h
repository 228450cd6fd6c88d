/// Robots whose attributes and texts say something odd, in a fixed order: formats, control characters, other
/// encodings, entities, numbers out of range, very long texts.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/// Every element that URDF has, and those of Gazebo, Drake, Bullet, ROS and ours that are read. It loads
/// without a warning of its texts.
inline std::string robotOfAllElements() {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<robot name="all" version="1.0" xmlns:haptic="https://haptic/urdf" xmlns:drake="https://drake.mit.edu">
<material name="red"><color rgba="1 0 0 1"/></material>
<material name="wood"><texture filename="wood.png"/></material>
<haptic:scene step="0.001" gravity="0 0 -9.81"/>
<link name="base" type="laser">
<inertial><origin xyz="0 0 0.01" rpy="0 0 0.1"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<visual name="seen"><origin xyz="0 0 0" quat_xyzw="0 0 0 1"/><geometry><box size="0.1 0.1 0.1"/></geometry><material name="red"/></visual>
<visual><geometry><mesh filename="package://none/base.stl" scale="1 1 1"/></geometry><material name="wood"/></visual>
<visual><geometry><capsule radius="0.02" length="0.1"/></geometry><material name=""><color rgba="0 1 0 1"/></material></visual>
<collision name="felt"><origin xyz="0 0 0" rpy="0 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry>
<haptic:contact stiffness="1e6" mu_static="0.5" mu_dynamic="0.4"/>
<drake:proximity_properties><drake:mu_static value="0.5"/></drake:proximity_properties>
</collision>
<contact><lateral_friction value="0.5"/><stiffness value="1000"/><damping value="10"/></contact>
<self_collision_checking><origin xyz="0 0 0"/><geometry><capsule radius="0.1" length="0.1"/></geometry></self_collision_checking>
</link>
<link name="arm">
<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><cylinder radius="0.02" length="0.2"/></geometry><material name="blue"><color rgba="0 0 1 1"/></material></visual>
<visual><geometry><sphere radius="0.03"/></geometry><material name="blue"/></visual>
<collision><geometry><cylinder radius="0.02" length="0.2"/></geometry><haptic:shape segments="16"/></collision>
</link>
<link name="finger">
<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.02"/></geometry></collision>
</link>
<link name="thumb">
<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><capsule radius="0.01" length="0.02"/></geometry></collision>
</link>
<link name="tip"/>
<joint name="shoulder" type="revolute">
<origin xyz="0 0 0.3" rpy="0 0.1 0"/><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<calibration rising="0" falling="0.1"/><dynamics damping="0.1" friction="0.01"/>
<limit lower="-1" upper="1" effort="10" velocity="2" acceleration="4" deceleration="4" jerk="10"/>
<safety_controller soft_lower_limit="-0.9" soft_upper_limit="0.9" k_position="10" k_velocity="1"/>
<haptic:joint position="0.1" drive="position" drive_stiffness="10" drive_damping="1"/>
</joint>
<joint name="slide" type="prismatic">
<origin xyz="0 0 0.3"/><parent link="arm"/><child link="finger"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="10" velocity="2"/>
</joint>
<joint name="follow" type="prismatic">
<origin xyz="0 0.2 0.3"/><parent link="arm"/><child link="thumb"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="10" velocity="2"/><mimic joint="slide" multiplier="-1" offset="0"/>
</joint>
<joint name="end" type="fixed"><origin xyz="0 0 0.1"/><parent link="finger"/><child link="tip"/></joint>
<transmission name="gear" type="SimpleTransmission"><type>transmission_interface/SimpleTransmission</type>
<joint name="shoulder"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
<actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
</transmission>
<sensor name="eye" update_rate="20"><parent link="base"/><origin xyz="0 0 0" rpy="0 0 0"/>
<camera><image width="640" height="480" format="RGB8" hfov="1.5" near="0.01" far="50"/></camera></sensor>
<gazebo><plugin name="control" filename="libcontrol.so"><robotNamespace>/all</robotNamespace></plugin></gazebo>
<gazebo reference="arm"><mu1>0.6</mu1><mu2>0.6</mu2><kp>1e6</kp><kd>10</kd><material>Gazebo/Red</material>
<sensor name="level" type="imu"><update_rate>100</update_rate><pose>0 0 0.1 0 0 0</pose>
<imu><angular_velocity><x><noise type="gaussian"><stddev>0.01</stddev></noise></x></angular_velocity></imu></sensor></gazebo>
<gazebo reference="shoulder"><sensor name="wrist" type="force_torque"><update_rate>100</update_rate>
<force_torque><frame>child</frame><measure_direction>parent_to_child</measure_direction></force_torque></sensor></gazebo>
<haptic:sensor name="touch" type="contact" link="arm" with="base" rate="500" noise_force="0.01"/>
<haptic:collision_filter link1="base" link2="finger"/>
</robot>
)";
}

/// Values that break readers: of formats, encodings, names, paths and numbers.
inline const std::vector<std::string>& oddTexts() {
  static const std::vector<std::string> texts = {
      // formats
      "%s%s%s%s%s%n%n%n", "%p %x %08lx %99999d", "%n", "%1$s %2$n", "100 %", "%", "",
      std::string(20000, '%') + "s",
      // long ones
      std::string(300, 'a'), std::string(100000, 'b'), "1 " + std::string(20000, '1'),
      // control characters, entities, encodings
      "a\x01"
      "b\x1f"
      "c\x7f",
      "line\nbreak\r\n\ttab", "&#1;&#7;&#0;&#27;[2J", "&#10;&#13;&#x2028;&#x85;",
      "&#xD800;&#x110000;&#99999999999;", "&lt;&amp;&quot;&apos;&gt;", "&unknown; &lt &;", "&#xZZ; &#; &#x;",
      "]]&gt;&lt;!--", "caf\xe9 \xff\xfe \xc0\xaf", "\xf0\x9f\xa4\x96 \xe6\x89\x8b", "\xed\xa0\x80",
      // paths
      "/", "//base", "../../../../etc/passwd", "package://", "package:///x", "package://../x",
      "file:///dev/null", "file:///", "model://%00%2e%2e/%ff", "~private/name",
      "a b 'c' {d} [e] $(find x) ${1/0}", "\\\\n\\\\0\\\\", ": - # | > ! * & @ `",
      // words that mean something elsewhere
      "world", "base", "arm", "shoulder", "fixed", "floating", "planar", "ball", "continuous", "mesh",
      "height_field", "rigid", "steel",
      // numbers
      "nan", "-nan(0x1)", "inf", "-inf", "1e400", "-1e400", "1e-400", "4.9e-324", "1.7976931348623157e308",
      "0x1p3", "1e9999999999999999999", "0", "-0", "-1", "0 0 0", "-1 -1 -1", "1e308 1e308 1e308",
      "1e-308 1e-308 1e-308", "nan nan nan", "0 0 0 0", "1 2 3 4 5", "1,5", "1;2", "1.2.3", "+", "-", "e",
      "--1", "1 1 1 ",
      "\xc2\xa0"
      "1",
      "true", "None", "2147483648", "-9223372036854775809", "18446744073709551616"};
  return texts;
}

/// Places of a URDF's text where something else may stand: the values of its attributes and the texts between
/// its tags.
struct OddPlaces {
  explicit OddPlaces(const std::string& urdf) : text(urdf) {
    char quote = 0;
    std::size_t begin = 0;
    bool in_tag = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (quote) {
        if (c == quote) spans.emplace_back(begin, i), quote = 0;
      } else if (in_tag && (c == '"' || c == '\'')) {
        quote = c, begin = i + 1;
      } else if (c == '<') {
        const bool words = text.find_first_not_of(" \t\r\n", begin) < i;
        if (!in_tag && begin > 0 && words) spans.emplace_back(begin, i);
        in_tag = true;
      } else if (c == '>') {
        in_tag = false, begin = i + 1;
      }
    }
  }

  /// The text with something else in place `span`.
  std::string with(std::size_t span, const std::string& other) const {
    std::string odd = text;
    return odd.replace(spans[span].first, spans[span].second - spans[span].first, other);
  }

  std::string text;                                        ///< as given
  std::vector<std::pair<std::size_t, std::size_t>> spans;  ///< begin and end of each
};

/// The file with number i. All pairs of a place and a text come before one comes again; neighbours differ in
/// both.
inline std::string oddFile(const OddPlaces& places, std::size_t i) {
  const std::vector<std::string>& texts = oddTexts();
  const std::size_t round = i / places.spans.size(), span = i % places.spans.size();
  return places.with(span, texts[(span + round) % texts.size()]);
}

}  // namespace haptic
