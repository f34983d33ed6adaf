// Runs Rapier for rapier.py: a task as JSON comes in, states and the processor time of the steps [s] go out.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

const R = createRequire(resolve(process.argv[2], "x.js"))("@dimforge/rapier2d-compat");
const task = JSON.parse(readFileSync(0, "utf8"));
await R.init();
if (!task.bodies) process.exit(0);

function simulate() {
  const world = new R.World({ x: 0, y: 0 });
  const { Max, Multiply } = R.CoefficientCombineRule;
  // Friction of two: the product. Disks have the root of theirs, and walls what makes their own of it.
  const still = world.createRigidBody(R.RigidBodyDesc.fixed());
  const walls = task.walls.map(([ax, ay, bx, by]) =>
    world.createCollider(
      R.ColliderDesc.segment({ x: ax, y: ay }, { x: bx, y: by })
        .setFriction(task.wall_friction)
        .setFrictionCombineRule(Multiply)
        .setRestitution(0)
        .setRestitutionCombineRule(Max),
      still,
    ),
  );
  const bodies = task.bodies.map((b) => {
    const [x, y, , vx, vy, w] = b.start;
    const body = world.createRigidBody(
      R.RigidBodyDesc.dynamic()
        .setTranslation(x, y)
        .setLinvel(vx, vy)
        .setAngvel(w)
        .setLinearDamping(b.along)
        .setAngularDamping(b.angular)
        .setCanSleep(false)
        .setAdditionalMassProperties(b.mass, { x: 0, y: 0 }, b.inertia),
    );
    const disks = b.disks.map((d) =>
      world.createCollider(
        R.ColliderDesc.ball(d.radius)
          .setTranslation(d.x, d.y)
          .setDensity(0)
          .setFriction(d.friction)
          .setFrictionCombineRule(Multiply)
          .setRestitution(d.restitution)
          .setRestitutionCombineRule(Max),
        body,
      ),
    );
    return { body, disks, turned: 0 };
  });
  const before = process.cpuUsage();
  for (const phase of task.phases) {
    world.timestep = phase.dt;
    bodies.forEach(({ body }, i) => {
      const [x, y, torque] = phase.drives[i];
      body.resetForces(true);
      body.resetTorques(true);
      body.addForce({ x, y }, true);
      body.addTorque(torque, true);
    });
    for (let k = 0; k < phase.steps; k++) {
      const old = bodies.map((b) => b.body.rotation());
      world.step();
      bodies.forEach((b, i) => {
        const turn = b.body.rotation() - old[i];
        b.turned += Math.atan2(Math.sin(turn), Math.cos(turn));
      });
    }
  }
  const used = process.cpuUsage(before);
  const load = (disk) => {
    let impulse = 0;
    for (const wall of walls)
      world.contactPair(disk, wall, (manifold) => {
        for (let i = 0; i < manifold.numContacts(); i++) impulse += manifold.contactImpulse(i);
      });
    return impulse / world.timestep;
  };
  const states = bodies.map(({ body, disks, turned }, i) => ({
    x: body.translation().x,
    y: body.translation().y,
    theta: task.bodies[i].start[2] + turned,
    vx: body.linvel().x,
    vy: body.linvel().y,
    omega: body.angvel(),
    wall: disks.reduce((sum, disk) => sum + load(disk), 0),
  }));
  return { bodies: states, cost: (used.user + used.system) / 1e6 };
}

// The first runs are slower, while WebAssembly is compiled.
const runs = Array.from({ length: 20 }, simulate).slice(10);
console.log(JSON.stringify({ ...runs[0], cost: runs.reduce((sum, run) => sum + run.cost, 0) / runs.length }));
