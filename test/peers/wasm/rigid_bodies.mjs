// node rigid_bodies.mjs FOLDER: Jolt or Rapier of FOLDER/node_modules, stepped as wasm_world.cpp tells: a scene as JSON, its size in bytes in
// front, then for each step the factor on friction (NaN ends the world) and by body a force and a torque about C, in W. Back go, at the start
// and after each step, by body p_WC, q_WC (w first), and the velocities at C, angular first. Both compute in single precision.
import {load, numbers, receive, send} from './pipe.mjs';

const once = (make) => {
  let made;
  return () => (made ??= make());
};
const loaded = {
  rapier: once(async () => {
    const R = (await load('@dimforge/rapier3d-compat/dist/rapier.mjs')).default;
    await R.init();
    return R;
  }),
  jolt: once(async () => (await load('jolt-physics/dist/jolt-physics.wasm-compat.js')).default()),
};

/// Bodies are placed by their centres of mass; X of a shape is in the axes of its body, from C.
const engines = {
  rapier: async (scene) => {
    const R = await loaded.rapier();
    const vector = ([x, y, z]) => ({x, y, z}), rotation = ([w, x, y, z]) => ({w, x, y, z});
    const world = new R.World(vector(scene.gravity)), settings = world.integrationParameters;
    settings.dt = scene.step;
    settings.normalizedPredictionDistance = 1e-3;
    if (scene.firm) {
      settings.numSolverIterations = 50;
      settings.normalizedAllowedLinearError = 1e-6;
      settings.contact_natural_frequency = 0.2 / scene.step;
    }
    const shapeOf = {
      sphere: (s) => R.ColliderDesc.ball(s.radius),
      capsule: (s) => R.ColliderDesc.capsule(s.length / 2, s.radius),
      cylinder: (s) => R.ColliderDesc.cylinder(s.length / 2, s.radius),
      box: (s) => R.ColliderDesc.cuboid(...s.half),
      hull: (s) => R.ColliderDesc.convexHull(Float32Array.from(s.points)),
      plane: () => new R.ColliderDesc(new R.HalfSpace(vector([0, 0, 1]))),
    };
    const bodies = scene.bodies.map((b) => {
      const desc = (b.fixed ? R.RigidBodyDesc.fixed() : R.RigidBodyDesc.dynamic()).setTranslation(...b.p).setRotation(rotation(b.q));
      if (!b.fixed) {
        desc.setLinvel(...b.v).setAngvel(vector(b.w)).setCanSleep(false);
        desc.setAdditionalMassProperties(b.mass, vector([0, 0, 0]), vector(b.inertia), rotation(b.axes));
      }
      const body = world.createRigidBody(desc);
      for (const s of b.shapes) {
        const collider = shapeOf[s.kind](s).setTranslation(...s.p).setRotation(rotation(s.q)).setDensity(0);
        collider.setFriction(Math.sqrt(b.mu)).setFrictionCombineRule(R.CoefficientCombineRule.Multiply);
        world.createCollider(collider.setRestitution(scene.restitution), body);
      }
      return body;
    });
    return {
      act: (i, f, t) => {
        bodies[i].addForce(vector(f), true);
        bodies[i].addTorque(vector(t), true);
      },
      scaleFriction: (factor) => bodies.forEach((body, i) => {
        for (let c = 0; c < body.numColliders(); ++c) {
          const collider = body.collider(c);
          collider.setFriction(Math.sqrt(factor * scene.bodies[i].mu));
          collider.setShape(collider.shape);  // a contact that is there keeps its friction otherwise
        }
      }),
      step: () => {
        world.step();
        for (const body of bodies) body.resetForces(false), body.resetTorques(false);
      },
      state: (i, out) => {
        const p = bodies[i].translation(), q = bodies[i].rotation(), v = bodies[i].linvel(), w = bodies[i].angvel();
        out.set([p.x, p.y, p.z, q.w, q.x, q.y, q.z, w.x, w.y, w.z, v.x, v.y, v.z]);
      },
      end: () => world.free(),
    };
  },

  jolt: async (scene) => {
    const J = await loaded.jolt();
    const vector = (v) => new J.Vec3(...v), place = (v) => new J.RVec3(...v), rotation = ([w, x, y, z]) => new J.Quat(x, y, z, w);
    const kStill = 0, kMoving = 1, settings = new J.JoltSettings();
    const layers = new J.ObjectLayerPairFilterTable(2), broad = new J.BroadPhaseLayerInterfaceTable(2, 2);
    layers.EnableCollision(kStill, kMoving);
    layers.EnableCollision(kMoving, kMoving);
    for (const layer of [kStill, kMoving]) broad.MapObjectToBroadPhaseLayer(layer, new J.BroadPhaseLayer(layer));
    settings.mObjectLayerPairFilter = layers;
    settings.mBroadPhaseLayerInterface = broad;
    settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(broad, 2, layers, 2);
    const jolt = new J.JoltInterface(settings), system = jolt.GetPhysicsSystem(), world = system.GetBodyInterface();
    system.SetGravity(vector(scene.gravity));
    const physics = system.GetPhysicsSettings();
    physics.mAllowSleeping = false;
    physics.mSpeculativeContactDistance = 1e-3;
    physics.mPenetrationSlop = scene.firm ? 1e-6 : 1e-3;
    if (scene.restitution > 0) physics.mMinVelocityForRestitution = 0;
    if (scene.firm) physics.mNumVelocitySteps = 50, physics.mNumPositionSteps = 10;
    system.SetPhysicsSettings(physics);
    const shapeOf = {
      sphere: (s) => new J.SphereShapeSettings(s.radius),
      capsule: (s) => new J.CapsuleShapeSettings(s.length / 2, s.radius),
      cylinder: (s) => new J.CylinderShapeSettings(s.length / 2, s.radius, 0),
      box: (s) => new J.BoxShapeSettings(vector(s.half), 0),
      hull: (s) => {
        const hull = new J.ConvexHullShapeSettings();
        hull.mMaxConvexRadius = 0;
        for (let k = 0; k < s.points.length; k += 3) hull.mPoints.push_back(vector(s.points.slice(k, k + 3)));
        return hull;
      },
      plane: (s) => {
        const n = rotation(s.q).RotateAxisZ();
        return new J.PlaneShapeSettings(new J.Plane(n, -n.Dot(vector(s.p))));
      },
    };
    const built = (made) => {
      const shape = made.Create().Get();
      shape.AddRef();  // the result, which holds it, is that of the next call too
      return shape;
    };
    const shapeAbout = (b) => {  // what moves: with its middle where its centre of mass is
      if (b.shapes.length === 0) return built(new J.SphereShapeSettings(1e-3));
      if (b.shapes[0].kind === 'plane') return built(shapeOf.plane(b.shapes[0]));
      const compound = new J.StaticCompoundShapeSettings();
      for (const s of b.shapes) compound.AddShape(vector(s.p), rotation(s.q), shapeOf[s.kind](s), 0);
      const shape = built(compound);
      if (b.fixed) return shape;
      const c = shape.GetCenterOfMass();
      return built(new J.OffsetCenterOfMassShapeSettings(new J.Vec3(-c.GetX(), -c.GetY(), -c.GetZ()), compound));
    };
    const bodies = scene.bodies.map((b) => {
      const type = b.fixed ? J.EMotionType_Static : J.EMotionType_Dynamic;
      const made = new J.BodyCreationSettings(shapeAbout(b), place(b.p), rotation(b.q), type, b.fixed ? kStill : kMoving);
      made.mFriction = b.mu;  // of a pair: the root of the product
      made.mRestitution = scene.restitution;
      made.mLinearDamping = made.mAngularDamping = 0;
      made.mApplyGyroscopicForce = true;
      made.mMaxLinearVelocity = made.mMaxAngularVelocity = 1e4;
      made.mAllowSleeping = false;
      if (!b.fixed) {
        made.mLinearVelocity = vector(b.v);
        made.mAngularVelocity = vector(b.w);
        made.mOverrideMassProperties = J.EOverrideMassProperties_MassAndInertiaProvided;
        made.mMassPropertiesOverride.mMass = b.mass;
        const inertia = J.Mat44.prototype.sIdentity();
        for (const axis of [0, 1, 2]) inertia.SetColumn3(axis, vector(b.about_c.slice(3 * axis, 3 * axis + 3)));
        made.mMassPropertiesOverride.mInertia = inertia;
      }
      const body = world.CreateBody(made);
      world.AddBody(body.GetID(), J.EActivation_Activate);
      if (b.shapes.length === 0) body.SetIsSensor(true);
      return body;
    });
    return {
      act: (i, f, t) => {
        if (scene.bodies[i].fixed) return;
        bodies[i].AddForce(vector(f));
        bodies[i].AddTorque(vector(t));
      },
      scaleFriction: (factor) => bodies.forEach((body, i) => body.SetFriction(factor * scene.bodies[i].mu)),
      step: () => jolt.Step(scene.step, 1),
      state: (i, out) => {
        const p = bodies[i].GetCenterOfMassPosition(), q = bodies[i].GetRotation();
        out.set([p.GetX(), p.GetY(), p.GetZ(), q.GetW(), q.GetX(), q.GetY(), q.GetZ()]);
        const w = bodies[i].GetAngularVelocity();
        out.set([w.GetX(), w.GetY(), w.GetZ()], 7);
        const v = bodies[i].GetLinearVelocity();
        out.set([v.GetX(), v.GetY(), v.GetZ()], 10);
      },
      end: () => J.destroy(jolt),
    };
  },
};

for (;;) {
  const scene = JSON.parse(receive(numbers(1)[0]).toString());
  const count = scene.bodies.length, world = await engines[scene.engine](scene), states = new Float64Array(13 * count);
  for (let scale = 1;;) {
    for (let i = 0; i < count; ++i) world.state(i, states.subarray(13 * i, 13 * i + 13));
    send(states);
    const told = numbers(1 + 6 * count), wrenches = told.subarray(1);
    if (Number.isNaN(told[0])) break;
    if (told[0] !== scale) world.scaleFriction(scale = told[0]);
    for (let i = 0; i < count; ++i) {
      const own = wrenches.subarray(6 * i, 6 * i + 6);
      if (own.some((x) => x !== 0)) world.act(i, own.subarray(0, 3), own.subarray(3));
    }
    world.step();
  }
  world.end();
}
