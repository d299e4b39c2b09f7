//! Broken files, each with all that is said of it.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{fs, path::Path};

use formats::{Options, import, import_text};

/// Of a file `robot.xml`: its text, and the problems.
const BROKEN: &[(&str, &str)] = &[
    (r#""#, r#"robot.xml:1:1: not well-formed XML: the file ends too early"#),
    (r#"name = "worm""#, r#"robot.xml:1:1: not well-formed XML: unknown token"#),
    (r#"<robot name="r">"#, r#"robot.xml:1:17: not well-formed XML: the file ends too early"#),
    (
        r#"<robot><link name="a"></robot>"#,
        r#"robot.xml:1:23: not well-formed XML: expected 'link' tag, not 'robot'"#,
    ),
    (
        r#"<robot name="a" name="b"/>"#,
        r#"robot.xml:1:17: not well-formed XML: attribute 'name' is already defined"#,
    ),
    (
        r#"<robot name="&lol;"/>"#,
        r#"robot.xml:1:14: not well-formed XML: unknown entity reference 'lol'"#,
    ),
    (
        r#"<!DOCTYPE r [<!ENTITY a "b">]>
<robot name="&a;"/>"#,
        r#"robot.xml:1:1: a file without a DTD expected, got one: take it out, and entities with it"#,
    ),
    (
        r#"<html/>"#,
        r#"robot.xml:1:1: a robot in URDF (<robot>), MJCF (<mujoco>), SDF (<sdf>) or RoSiML (<rosiml>) expected, got <html>"#,
    ),
    (r#"<mujocoinclude/>"#, r#"robot.xml:1:1: a whole model expected, got a part of one in MJCF"#),
    (
        r#"<robot name="r">
<xacro:include filename="a"/></robot>"#,
        r#"robot.xml:1:1: a robot in URDF expected, got xacro: run xacro first"#,
    ),
    (
        r#"<robot name="r">
  <link name="a"/>
</robot>
<robot/>"#,
        r#"robot.xml:4:1: not well-formed XML: unknown token"#,
    ),
    ("\u{1}", r#"robot.xml:1:1: not well-formed XML: unknown token"#),
    (r#"<robot name="r"/>"#, r#"robot.xml:1:1: a robot must have a <link>, got none"#),
    (
        r#"<robot name="r"><link/></robot>"#,
        r#"robot.xml:1:17: <link> must have name="...", got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#,
        r#"robot.xml:1:111: there is another link 'a'"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#,
        r#"robot.xml:1:111: 'b' must be the child of a joint, as all links but one ('a') are"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="c"/></joint></robot>"#,
        r#"robot.xml:1:265: link of <child> must be a link's name, got "c""#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="bb"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="bbb"/></joint></robot>"#,
        r#"robot.xml:1:266: link of <child> must be a link's name, got "bbb", did you mean 'bb'?"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:205: <joint> must have a <parent>, got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="spinning"><parent link="a"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:227: type of <joint> must be one of revolute, continuous, prismatic, fixed, floating, planar, spherical, got "spinning""#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint type="fixed"><parent link="a"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:205: <joint> must have name="...", got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j"><parent link="a"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:205: <joint> 'j' must have type="...", got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="a"/></joint></robot>"#,
        r#"robot.xml:1:111: joints must not go round in a circle, but every link is a child"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="b"/><child link="c"/></joint><joint name="k" type="fixed"><parent link="c"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:299: joint 'j' must not hang on its own child: a circle"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint><joint name="k" type="fixed"><parent link="a"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:277: joint 'k': 'b' is the child of 'j' too"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 0"/><limit lower="-1" upper="1"/></joint></robot>"#,
        r#"robot.xml:1:283: xyz of <axis> must be a direction, got 0 0 0"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0"/></joint></robot>"#,
        r#"robot.xml:1:283: xyz of <axis> must have 3 numbers, got 2"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/><limit lower="a" upper="1"/></joint></robot>"#,
        r#"robot.xml:1:286: lower of <limit> must be a number, got "a""#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 nan 0"/></joint></robot>"#,
        r#"robot.xml:1:284: xyz of <origin> must be a finite number, got nan"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 0 ${h}"/></joint></robot>"#,
        r#"robot.xml:1:286: xyz of <origin> must be a number, got "${h}" (a leftover of xacro: run xacro first)"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 inf 0"/></joint></robot>"#,
        r#"robot.xml:1:284: xyz of <origin> must be a finite number, got inf"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="5000 0 0"/></joint></robot>"#,
        r#"robot.xml:1:111: 'b' must be within 1000 m, got 5000 m"#,
    ),
    (
        r#"<robot name="r">
 <link name="a">
  <inertial>
   <mass value="-1"/></inertial></link></robot>"#,
        r#"robot.xml:4:17: value of <mass> must be 0 or more, got -1"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1e9"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"#,
        r#"robot.xml:1:17: the mass of 'a' must be at most 1e6 kg, got 1000000000"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1e16" iyy="1e16" izz="1e16"/></inertial></link></robot>"#,
        r#"robot.xml:1:17: moments of inertia of 'a' must be at most 1e15 kg m², got 1e16"#,
    ),
    (
        r#"<robot name="r"><link name="a"><collision/></link></robot>"#,
        r#"robot.xml:1:32: <collision> must have a <geometry>, got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><collision><geometry><sphere radius="-1"/></geometry></collision></link></robot>"#,
        r#"robot.xml:1:53: the sizes of a shape must be above 0"#,
    ),
    (
        r#"<robot name="r"><link name="a"><collision><geometry><box/></geometry></collision></link></robot>"#,
        r#"robot.xml:1:53: <box> must have size="...", got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><collision><geometry><cylinder radius="1"/></geometry></collision></link></robot>"#,
        r#"robot.xml:1:53: <cylinder> must have length="...", got none"#,
    ),
    (
        r#"<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="floating"><parent link="a"/><child link="b"/></joint></robot>"#,
        r#"robot.xml:1:205: joint 'j' must not float: only what hangs on a root that weighs nothing can"#,
    ),
    (r#"<mujoco/>"#, r#"robot.xml:1:1: a model must have a <body> in its <worldbody>, got none"#),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/><body name="a"><geom size="1"/></body></body></worldbody></mujoco>"#,
        r#"robot.xml:1:63: there is another body 'a'"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom type="cube" size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:47: type of <geom> must be one of plane, hfield, sphere, capsule, ellipsoid, cylinder, box, mesh, sdf, got "cube""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="-1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:47: size of <geom> must be above 0, got -1"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom type="box" size="1 1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:58: size of a <geom> box must have 3 numbers, got 2"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom type="capsule" fromto="0 0 0 0 0 0" size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:64: fromto of <geom> must have two points, got the same twice"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1" density="-5"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:59: density of <geom> must be 0 or more, got -5"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:59: mesh of <geom> must be the name of a <mesh>, got "m""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1" class="leg"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:57: class of <geom> must be the class of a <default>, got "leg""#,
    ),
    (
        r#"<mujoco><default><default class="leg"/></default><worldbody><body name="a"><geom size="1" class="let"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:98: class of <geom> must be the class of a <default>, got "let", did you mean 'leg'?"#,
    ),
    (
        r#"<mujoco><default><default/></default><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:18: <default> must have class="...", got none"#,
    ),
    (
        r#"<mujoco><compiler angle="grad"/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:26: angle of <compiler> must be one of degree, radian, got "grad""#,
    ),
    (
        r#"<mujoco><compiler eulerseq="xyw"/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:29: eulerseq of <compiler> must be three of x, y, z, X, Y, Z, got "xyw""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1" quat="0 0 0 0"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:56: quat of <geom> must be a rotation, got 0"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/><joint type="screw"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:64: type of <joint> must be one of free, ball, slide, hinge, fixed, got "screw""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/><joint axis="0 0 0"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:64: axis of <joint> must be a direction, got 0 0 0"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/><body><geom size="1"/><freejoint/></body></body></worldbody></mujoco>"#,
        r#"robot.xml:1:73: a free joint must be of a body in the world itself"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/><joint name="j" range="a b"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:74: range of <joint> must be a number, got "a""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><inertial pos="0 0 0"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:35: <inertial> must have mass="...", got none"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><inertial mass="-1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:51: mass of <inertial> must be 0 or more, got -1"#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody><actuator><motor joint="knee"/></actuator></mujoco>"#,
        r#"robot.xml:1:94: joint of <motor> must be the name of a <joint>, got "knee""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody><contact><exclude body1="a" body2="b"/></contact></mujoco>"#,
        r#"robot.xml:1:105: body2 of <exclude> must be the name of a <body>, got "b""#,
    ),
    (
        r#"<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody><contact><exclude body1="a"/></contact></mujoco>"#,
        r#"robot.xml:1:79: <exclude> must have body2="...", got none"#,
    ),
    (
        r#"<mujoco><include/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:9: <include> must have file="...", got none"#,
    ),
    (
        r#"<mujoco><include file="not there.xml"/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:24: file of <include>: ./not there.xml: can't be read: No such file or directory (os error 2)"#,
    ),
    (
        r#"<mujoco><include file="/etc/passwd"/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>"#,
        r#"robot.xml:1:24: file of <include> is outside the file's folder: --package NAME=DIR allows what is in DIR"#,
    ),
    (
        r#"<mujoco><worldbody><replicate count="1000000"><body><geom size="1"/></body></replicate></worldbody></mujoco>"#,
        r#"robot.xml:1:38: count of <replicate> must be 1 to 1000, got 1000000"#,
    ),
    (r#"<sdf version="1.7"/>"#, r#"robot.xml:1:1: a file must have a <model>, got none"#),
    (
        r#"<sdf version="1.7"><model name="m"></model></sdf>"#,
        r#"robot.xml:1:20: a model must have a <link>, got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link/></model></sdf>"#,
        r#"robot.xml:1:36: <link> must have name="...", got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="a"/></model></sdf>"#,
        r#"robot.xml:1:52: there is another 'a' in its model"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><pose>0 0 0</pose></link></model></sdf>"#,
        r#"robot.xml:1:51: <pose> must have 6 numbers, got 3"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><pose relative_to="b">0 0 0 0 0 0</pose></link></model></sdf>"#,
        r#"robot.xml:1:36: <link> must refer to a link, a joint or a frame of its model, got "b""#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><pose relative_to="f"/></link><frame name="f"><pose relative_to="a"/></frame></model></sdf>"#,
        r#"robot.xml:1:36: poses must not be relative to each other in a circle"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><inertial><mass>-1</mass></inertial></link></model></sdf>"#,
        r#"robot.xml:1:61: <mass> must be 0 or more, got -1"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j"><parent>a</parent><child>b</child></joint></model></sdf>"#,
        r#"robot.xml:1:68: <joint> 'j' must have type="...", got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent><child>b</child></joint></model></sdf>"#,
        r#"robot.xml:1:68: <joint> must have an <axis>, got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent><child>c</child><axis/></joint></model></sdf>"#,
        r#"robot.xml:1:118: <child> must refer to a link, a joint or a frame of its model, got "c""#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="fixed"><child>b</child></joint></model></sdf>"#,
        r#"robot.xml:1:68: <joint> must have a <parent>, got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 0</xyz></axis></joint></model></sdf>"#,
        r#"robot.xml:1:134: <xyz> must be a direction, got 0 0 0"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><collision name="c"><geometry><sphere/></geometry></collision></link></model></sdf>"#,
        r#"robot.xml:1:81: <sphere> must have a <radius>, got none"#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz expressed_in="q">0 0 1</xyz></axis></joint></model></sdf>"#,
        r#"robot.xml:1:134: <axis> must refer to a link, a joint or a frame of its model, got "q""#,
    ),
    (
        r#"<sdf version="1.7"><model name="m"><link name="a"><collision name="c"><geometry><sphere><radius>one</radius></sphere></geometry></collision></link></model></sdf>"#,
        r#"robot.xml:1:97: <radius> must be a number, got "one""#,
    ),
    (r#"<rosiml/>"#, r#"robot.xml:1:1: a file must have <robots> with a <robot>, got none"#),
    (
        r#"<rosiml><robots><robot name="r"></robot></robots></rosiml>"#,
        r#"robot.xml:1:17: a robot must have a <body> with parts in it, got none"#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="1"/></physics></box><box name="b"/></body></robot></robots></rosiml>"#,
        r#"robot.xml:1:135: <box> must have a <dimension>, got none"#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="1"/></physics></box><box name="a"><dimension width="1" depth="1" height="1"/></box></body></robot></robots></rosiml>"#,
        r#"robot.xml:1:135: there is another body 'a'"#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="1"/></physics></box><sphere name="b"><dimension/></sphere></body></robot></robots></rosiml>"#,
        r#"robot.xml:1:152: <dimension> must have radius="...", got none"#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="1"/></physics></box></body><actuators><hinge name="h"><source name="b"/></hinge></actuators></robot></robots></rosiml>"#,
        r#"robot.xml:1:183: name of <source> must be a body's, got "b""#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="1"/></physics></box></body><actuators><hinge name="h"/></actuators></robot></robots></rosiml>"#,
        r#"robot.xml:1:153: <hinge> must have a <source>, got none"#,
    ),
    (
        r#"<rosiml><robots><robot name="r"><body><box name="a"><dimension width="1" depth="1" height="1"/><physics><mass kg="-1"/></physics></box></body></robot></robots></rosiml>"#,
        r#"robot.xml:1:115: kg of <mass> must be 0 or more, got -1"#,
    ),
];

#[test]
fn every_mistake_has_its_place_and_its_message() {
    assert!(BROKEN.len() >= 60);
    let mut wrong = Vec::new();
    for (text, expected) in BROKEN {
        let found = import_text(Path::new("robot.xml"), (*text).into(), &Options::default());
        let found = match found {
            Ok(_) => "nothing".into(),
            Err(problems) => problems.to_string(),
        };
        if found != *expected {
            wrong.push(format!("{text}\n  expected: {expected}\n  found:    {found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What has to do with files, and with what can't be written in a table.
#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let said = |name: &str| import(&at(name), &Options::default()).unwrap_err().to_string();
    let path = |name: &str| at(name).display().to_string();

    assert!(said("none.urdf").starts_with(&format!("{}: can't be read: ", path("none.urdf"))));
    fs::create_dir(at("folder.urdf")).unwrap();
    assert!(said("folder.urdf").starts_with(&format!("{}: can't be read: ", path("folder.urdf"))));
    fs::write(at("bytes.urdf"), b"<robot>\n  \xff").unwrap();
    let expected = format!("{}:2:3: text in UTF-8 expected, got the byte 0xff", path("bytes.urdf"));
    assert_eq!(said("bytes.urdf"), expected);
    // A sparse one: nothing of it is written.
    fs::File::create(at("large.urdf")).unwrap().set_len(100 << 20).unwrap();
    let expected = format!("{}: a file of at most 16 MiB expected, got more", path("large.urdf"));
    assert_eq!(said("large.urdf"), expected);

    let body = "<worldbody><body><geom size=\"1\"/></body></worldbody>";
    let include = |file: &str| format!("<mujoco>{body}\n  <include file=\"{file}\"/></mujoco>");
    fs::create_dir(at("inner")).unwrap();
    fs::write(at("a.xml"), include("inner/b.xml")).unwrap();
    fs::write(at("inner/b.xml"), "<mujoco>\n  <compiler angle=\"grad\"/></mujoco>").unwrap();
    let expected = format!(
        "{}:2:20: angle of <compiler> must be one of degree, radian, got \"grad\"",
        path("inner/b.xml")
    );
    assert_eq!(said("a.xml"), expected, "from inside an include");
    fs::write(at("inner/b.xml"), "<mujoco>\n  <compiler").unwrap();
    let expected =
        format!("{}:2:12: not well-formed XML: the file ends too early", path("inner/b.xml"));
    assert_eq!(said("a.xml"), expected);
    fs::write(at("inner/c.xml"), include("../a.xml")).unwrap();
    let expected = format!(
        "{}:2:18: file of <include> is outside the file's folder: --package NAME=DIR allows what is \
         in DIR",
        path("inner/c.xml")
    );
    assert_eq!(said("inner/c.xml"), expected);
    let options =
        Options { packages: vec![("all".into(), folder.path().into())], ..Options::default() };
    fs::write(at("a.xml"), "<mujoco/>").unwrap();
    assert!(import(&at("inner/c.xml"), &options).is_ok(), "asked for");

    let text = "<mujoco><worldbody><body name=\"a\"><geom size=\"1\"/></body></worldbody></mujoco>";
    fs::write(at("feet.xml"), text).unwrap();
    let options = Options { feet: Some(vec!["b".into()]), ..Options::default() };
    let problems = import(&at("feet.xml"), &options).unwrap_err();
    let expected = format!("{}: --feet must be names of bodies, got \"b\"", path("feet.xml"));
    assert_eq!(problems.to_string(), expected);
}

/// What others take in silence is taken, and said.
#[test]
fn what_is_nearly_right_is_read_and_told() {
    let text = "<robot name=\"r\"><link name=\"a\"><drake:x/><inertial>\
        <origin xyz=\"0, 0, 1.5.\" rpy=\"0 0 0 0\"/><mass value=\"1\"/>\
        <inertia ixx=\"0\" iyy=\"0\" izz=\"0\"/></inertial>\
        <collision><geometry><mesh filename=\"none.stl\"/></geometry></collision></link></robot>";
    let imported = import_text(Path::new("robot.xml"), text.into(), &Options::default()).unwrap();
    assert!(imported.text.contains("position_m = [0.0, 0.0, 1.5]"), "{}", imported.text);
    let report = imported.report.to_string();
    for row in [
        "xyz of <origin> with commas: they are spaces",
        "xyz of <origin>: `1.5.`, which isn't a number: 1.5",
        "rpy of <origin> with 4 numbers: the first 3",
        "moments of inertia that aren't above 0: a ball's, of water",
        "mesh none.stl",
        "isn't there",
        "the shape of a link whose mesh can't be used: a box with its inertia",
        "link/drake:x",
    ] {
        assert!(report.contains(row), "{row:?} isn't in {report}");
    }
    assert!(!imported.report.is_complete());
}
