"""Models that use what Gymnasium's do not."""

FRAMES = """
<mujoco model="frames">
  <compiler angle="degree" eulerseq="zyX" balanceinertia="true"/>
  <worldbody>
    <geom type="plane" size="1 1 .1" euler="0 10 0"/>
    <frame pos="1 0 0" euler="0 0 90">
      <body name="a" pos="0 0 1" axisangle="1 1 0 30">
        <frame pos="0.1 0 0" zaxis="1 0 1">
          <joint name="a1" axis="1 2 0" pos="0 0.1 0"/>
          <geom name="a_box" type="box" size=".1 .2 .3" pos="0 0 .1" xyaxes="1 1 0 0 1 1"/>
          <site name="a_site" pos="1 0 0" euler="10 20 30"/>
          <camera name="a_cam" pos="0 0 1" quat="1 1 0 0" fovy="60"/>
          <body name="a_inner" pos="0 0 .5" euler="5 6 7">
            <geom type="ellipsoid" size=".1 .2 .15"/>
          </body>
        </frame>
        <geom name="a_cyl" type="cylinder" fromto="0 0 0 .3 .2 .1" size=".05" mass="2"/>
      </body>
    </frame>
    <body name="b" pos="-1 0 1">
      <freejoint name="b_free"/>
      <inertial pos=".1 0 0" mass="3" diaginertia=".1 .2 .25" euler="20 0 0"/>
      <geom size=".1"/>
    </body>
    <body name="c" pos="-2 0 1">
      <joint type="ball" name="c_ball" range="0 80" damping="0.1"/>
      <inertial pos=".1 .2 .3" mass="3" fullinertia=".3 .35 .25 .01 .02 -.03"/>
    </body>
    <geom type="box" fromto="0 0 0 1 0 .1" size=".1 .2 .3"/>
    <body name="m" mocap="true" pos="0 3 0"><geom size=".1" contype="0" conaffinity="0"/></body>
    <replicate count="3" offset=".5 0 0" euler="0 0 30" sep="-">
      <body name="r" pos="0 5 0"><freejoint/><geom name="g" type="capsule" size=".1 .2"/></body>
    </replicate>
  </worldbody>
</mujoco>
"""

DEFAULTS = """
<mujoco model="defaults">
  <compiler angle="radian" inertiagrouprange="0 2" settotalmass="7" boundmass="0.01" boundinertia="0.001"/>
  <option timestep="0.005" gravity="0 1 -5"/>
  <default>
    <geom friction=".5 .1 .01" density="500" condim="4"/>
    <joint damping="1" armature=".1"/>
    <position kp="50" kv="3"/>
    <default class="soft">
      <geom friction=".7" size=".1 .2 .3" euler="0 0 .3"/>
      <joint stiffness="3" springref=".2" ref=".1" range="-1 1"/>
      <general gear="2 1" ctrlrange="-3 3"/>
      <default class="softer"><joint stiffness="1"/><site size=".02"/></default>
    </default>
  </default>
  <worldbody>
    <body name="a" childclass="soft">
      <joint name="j0" frictionloss=".3"/>
      <geom type="box"/>
      <geom type="capsule" size=".05" quat="1 0 1 0" group="3"/>
      <body name="b" childclass="softer" pos="0 0 1">
        <joint name="j1" axis="0 1 0" actuatorfrcrange="-2 3"/>
        <joint name="j2" type="slide" class="main" limited="false" range="0 1"/>
        <geom class="main" type="sphere" size=".3"/>
        <site name="s"/>
        <body name="welded" pos="0 0 1"><geom type="cylinder"/></body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="b" body2="a"/></contact>
  <equality>
    <joint joint1="j1" joint2="j2" polycoef="0 2"/>
    <connect body1="a" body2="welded" anchor="0 0 1"/>
    <weld body1="a"/>
  </equality>
  <actuator>
    <motor name="m0" joint="j0" class="soft" gear="30"/>
    <motor name="m1" joint="j1" ctrllimited="true" ctrlrange="-1 1" forcerange="-2 2"/>
    <position name="p0" joint="j0"/>
    <position name="p1" joint="j1" kp="5" inheritrange=".5"/>
    <velocity name="v0" joint="j0" kv="7"/>
    <general name="g0" joint="j1" gainprm="3" biastype="affine" biasprm="1 -2 -3"/>
  </actuator>
  <sensor>
    <jointpos joint="j0"/><jointvel joint="j1"/><framepos objtype="site" objname="s"/><touch site="s"/>
    <force site="s"/><actuatorfrc actuator="m0"/>
  </sensor>
  <keyframe><key name="k" qpos=".1 .2 .3" ctrl="1 2 3 4 5 6"/></keyframe>
</mujoco>
"""

CHAIN = """
<mujoco model="chain">
  <compiler angle="degree"/>
  <default><joint armature=".1" damping=".2"/></default>
  <worldbody>
    <body pos="0 0 2">
      <joint name="yaw" axis="0 0 1" stiffness="2" springref="20" ref="10"/>
      <geom type="box" size=".1 .2 .05" pos=".2 0 0"/>
      <body pos=".4 0 0" euler="10 20 30">
        <joint name="hip1" axis="1 1 0" pos=".1 0 0"/>
        <joint name="hip2" axis="1 -1 0" pos=".1 0 0" stiffness="5"/>
        <joint name="hip3" axis="0 0 1" pos=".1 0 0" armature="0"/>
        <geom type="box" size=".2 .05 .1" pos=".2 0 0"/>
        <body pos=".4 0 0">
          <joint name="slide" type="slide" axis="0 1 0" stiffness="400" damping="5"/>
          <joint name="knee" axis="0 1 0" pos="0 .1 0" damping="0"/>
          <geom type="capsule" fromto="0 0 0 .3 .1 .1" size=".05"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="yaw" gear="20" ctrlrange="-1 1"/>
    <position joint="hip1" kp="30" kv="1" ctrlrange="-1 1"/>
    <position joint="hip2" kp="20" gear="2" ctrlrange="-1 1"/>
    <velocity joint="hip3" kv="2" ctrlrange="-1 1"/>
    <general joint="knee" gear="-2" gainprm="3" biastype="affine" biasprm="1 -2 -.3" ctrlrange="-1 1"/>
    <motor joint="hip3" gear="-3" ctrlrange="-1 1"/>
  </actuator>
</mujoco>
"""

CROSSING = """
<mujoco model="crossing">
  <worldbody>
    <body pos="0 0 2">
      <joint name="a" axis="0 1 0"/>
      <joint name="b" axis="0 1 1" pos="0 0 .1"/>
      <geom type="box" size=".1 .2 .3" pos=".2 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""

EQUALITIES = """
<mujoco model="equalities">
  <worldbody>
    <body name="cart1" pos="0 0 1"><joint name="s1" type="slide" axis="0 0 -1" damping="1"/><geom size=".1"/></body>
    <body name="cart2" pos="1 0 1"><joint name="s2" type="slide" axis="0 0 1" ref=".5"/>
      <geom size=".1" density="3000"/></body>
    <body name="arm1" pos="3 0 1"><joint name="h1" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 .5 0 -.3" size=".05"/><site name="tip" pos=".5 0 0"/></body>
    <body name="arm2" pos="4 0 1"><joint name="h2" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 -.5 0 -.3" size=".05"/></body>
    <body name="held" pos="6 0 1"><freejoint/><geom type="box" size=".1 .2 .3"/></body>
    <body name="loose" pos="8 0 1"><freejoint/><geom name="ball" size=".1"/></body>
  </worldbody>
  <contact><exclude body1="arm1" body2="arm2"/></contact>
  <equality>
    <joint name="gear" joint1="s1" joint2="s2" polycoef="0 2"/>
    <connect name="pin" body1="arm1" body2="arm2" anchor=".5 0 -.3"/>
    <weld name="glue" body1="held"/>
    <weld name="off" body1="loose" active="false"/>
  </equality>
  <sensor>
    <jointpos name="q" joint="s2"/><framepos name="pose" objtype="xbody" objname="held"/>
    <touch name="touch" site="tip"/>
    <framelinvel name="velocity" objtype="body" objname="loose"/><torque name="load" site="tip"/>
    <clock name="time"/>
  </sensor>
</mujoco>
"""
