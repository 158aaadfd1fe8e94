"""Contacts and joints of a discrete MultibodyPlant of Drake (PyPI's `drake`).

    plant.SetUseSampledOutputPorts(False)  # before plant.Finalize()
    ...
    step = lcpbench.drake.capture(plant, plant.GetMyContextFromRoot(simulator.get_context()))
    answer = lcpbench.solve(step.problem)

Drake softens contacts on purpose. The problem is that of hard contacts. Limits of joints, constraints and PD controllers
are its bounded rows.
"""

from __future__ import annotations

import re
from typing import Any, Iterator

import numpy as np

from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _any_tangent
from ._rows import Rows

__all__ = ["capture", "shapes"]


def _joint_damping(plant: Any, context: Any) -> np.ndarray:
    damping = np.zeros(plant.num_velocities())
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities() > 0:
            first = joint.velocity_start()
            damping[first : first + joint.num_velocities()] = joint.GetDampingVector(context)
    return damping


def _is_tamsi(plant: Any) -> bool:
    from pydrake.multibody.plant import DiscreteContactApproximation

    return bool(plant.get_discrete_contact_approximation() == DiscreteContactApproximation.kTamsi)


def _forces(plant: Any, context: Any, actuation: np.ndarray) -> np.ndarray:
    """The generalized forces of a step but those of contacts and constraints, at the state before it."""
    from pydrake.multibody.tree import MultibodyForces

    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)  # damping of joints, too
    port = plant.get_applied_spatial_force_input_port()
    for each in port.Eval(context) if port.HasValue(context) else []:
        body = plant.get_body(each.body_index)
        turned = body.EvalPoseInWorld(context).rotation().inverse()
        body.AddInForce(context, np.array(each.p_BoBq_B), each.F_Bq_W.Rotate(turned), body.body_frame(), forces)
    tau = -np.array(plant.CalcInverseDynamics(context, np.zeros(plant.num_velocities()), forces))
    port = plant.get_applied_generalized_force_input_port()
    if port.HasValue(context):
        tau += port.Eval(context)
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        tau[actuator.joint().velocity_start()] += actuation[actuator.input_start()]
    return tau


def _constraints(plant: Any, context: Any) -> Iterator[tuple[Any, list[Any], Any]]:
    """Of each active constraint its id, the equations that pydrake has of it, and the indices of the positions in them.
    That of a weld has two: of its place, and of its turn."""
    from pydrake.multibody.inverse_kinematics import AddMultibodyPlantConstraints
    from pydrake.solvers import MathematicalProgram

    program = MathematicalProgram()
    q = program.NewContinuousVariables(plant.num_positions())
    found: list[tuple[list[Any], Any]] = []
    for each in AddMultibodyPlantConstraints(plant, q, program, context):
        text = each.evaluator().get_description()
        if text.startswith("Weld orientation"):
            found[-1][0].append(each.evaluator())
        elif re.match("Coupler|Distance|Ball|Weld", text):
            found.append(([each.evaluator()], program.FindDecisionVariableIndices(each.variables())))
    for each, (evaluators, positions) in zip(plant.GetConstraintIds(), found):  # both by kinds
        if plant.GetConstraintActiveStatus(context, each):
            yield each, evaluators, positions


def _add_constraints(plant: Any, context: Any, rows: Rows) -> int:
    """Returns how many constraints are of no kind that is known here."""
    from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable

    if plant.num_constraints() == 0:
        return 0
    h, nv, world, q = plant.time_step(), plant.num_velocities(), plant.world_frame(), plant.GetPositions(context)
    joint_at = {joint.position_start(): joint for joint in map(plant.get_joint, plant.GetJointIndices())
                if joint.num_positions() == 1}
    soft = plant.GetDistanceConstraintParams(context)
    count = 0

    def spatial(body: Any, point: np.ndarray) -> np.ndarray:
        """The angular velocity of a body and the velocity of its point, both of the world."""
        local = body.EvalPoseInWorld(context).inverse() @ point
        return np.array(plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, body.body_frame(), local, world,
                                                          world))

    for identifier, evaluators, positions in _constraints(plant, context):
        count += 1
        text = evaluators[0].get_description()
        if text.startswith("Coupler"):
            direction, names = np.zeros(nv), []
            for coefficient, position in zip(evaluators[0].GetDenseA()[0], positions):
                joint = joint_at[position]
                direction[joint.velocity_start()] += coefficient
                names.append((abs(coefficient) != 1.0, joint))
            first = min(names, key=lambda each: each[0])[1]  # q0 = ratio q1 + offset has q0's unit
            rows.add(f"coupler {' and '.join(joint.name() for _, joint in names)}", direction, first.can_rotate())
            continue
        if identifier in soft:
            of = soft[identifier]
            a, b = plant.get_body(of.bodyA()), plant.get_body(of.bodyB())
            P, Q = a.EvalPoseInWorld(context) @ of.p_AP(), b.EvalPoseInWorld(context) @ of.p_BQ()
        else:
            a, b = (plant.get_body(BodyIndex(int(each))) for each in re.findall(r"\d+", text))
            P, Q = (a.EvalPoseInWorld(context) @ each for each in (evaluators[0].lower_bound(), evaluators[0].Eval(q)))
        name = f"{text.split()[0].lower()} {a.name()} and {b.name()}"
        if len(evaluators) > 1:  # a weld, at the middle of its two places
            P = Q = 0.5 * (P + Q)
        J = spatial(b, Q) - spatial(a, P)
        if identifier in soft:
            distance = np.linalg.norm(Q - P)
            give, b_row = 0.0, 0.0
            if np.isfinite(of.stiffness()):  # SAP's model of a spring that is taken implicitly
                give = 1.0 / (h * (h * of.stiffness() + of.damping()))
                b_row = (distance - of.distance()) * of.stiffness() * h * give
            rows.add(name, (Q - P) / distance @ J[3:], False, b=b_row, compliance=give)
            continue
        for k, axis in enumerate("xyz"):
            rows.add(f"{name} {axis}", J[3 + k], False)
        for k, axis in enumerate("xyz" if len(evaluators) > 1 else ""):
            rows.add(f"{name} about {axis}", J[k], True)
    return sum(plant.GetConstraintActiveStatus(context, each) for each in plant.GetConstraintIds()) - count


def _add_joints(plant: Any, context: Any, actuation: np.ndarray, after: np.ndarray, rows: Rows) -> dict[int, float]:
    """Limits, locks and PD controllers of joints. Returns impulses by their rows, those that Drake tells of controllers, and
    zeros of limits that do not act; in actuation are then the forces that act beside the controllers."""
    h, nv, known = plant.time_step(), plant.num_velocities(), {}
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        first, count = joint.velocity_start(), joint.num_velocities()
        if count and joint.is_locked(context):
            for k in range(count):
                rows.add(f"lock {joint.name()}", np.eye(nv)[first + k], joint.can_rotate() and k < (3 if count == 6 else count))
        elif count == 1 and joint.num_positions() == 1:
            bounds = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
            q = float(joint.GetOnePosition(context))
            for sign, limit in zip((1.0, -1.0), bounds):
                there = rows.add_limit(f"joint limit {joint.name()}", np.eye(nv)[first], joint.can_rotate(), sign, q, limit, h)
                gap = sign * (q - limit)
                if there and (gap > 0 if _is_tamsi(plant) else sign * after[first] > -gap / (2 * h)):  # it does not act
                    known[len(rows) - 1] = 0.0
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        joint, instance, at = actuator.joint(), actuator.model_instance(), actuator.input_start()
        port = plant.get_desired_state_input_port(instance)
        if not actuator.has_controller() or joint.is_locked(context) or not port.HasValue(context):
            continue
        gains, place = actuator.get_controller_gains(), plant.GetJointActuatorIndices(instance).index(index)
        forward = plant.get_actuation_input_port(instance)
        beside = forward.Eval(context)[place] if forward.HasValue(context) else 0.0
        desired = port.Eval(context).reshape(2, -1)[:, place]
        give = 1.0 / (gains.d + h * gains.p)
        error = gains.p * (joint.GetOnePosition(context) - desired[0]) - gains.d * desired[1] - beside
        limit = h * actuator.effort_limit()
        if rows.add(f"motor {actuator.name()}", np.eye(nv)[joint.velocity_start()], joint.can_rotate(), lower=-limit,
                    upper=limit, b=float(error) * give, compliance=give / h):
            known[len(rows) - 1] = h * float(actuation[at])
        actuation[at] = 0.0
    return known


def _geometries(plant: Any, context: Any) -> tuple[Any, list[Any]]:
    """The query object, and the geometries that can touch others."""
    from pydrake.geometry import Role

    query = plant.get_geometry_query_input_port().Eval(context)
    return query, query.inspector().GetAllGeometryIds(Role.kProximity)


def shapes(plant: Any, context: Any) -> list[tuple[int, str, tuple[float, ...]]]:
    """For pictures: (body, type, size) of each geometry that can touch others, as `lcpbench.Recorder` takes them.
    Ellipsoids, meshes and convex hulls are the box around them.

    Args:
        plant, context: as those of `capture`.
    """
    query, geometries = _geometries(plant, context)
    result: list[tuple[int, str, tuple[float, ...]]] = []
    for i, each in enumerate(geometries):
        shape, around = query.inspector().GetShape(each), query.inspector().GetObbInGeometryFrame(each)
        kind = type(shape).__name__.lower()
        if kind == "sphere":
            result.append((i, kind, (shape.radius(),)))
        elif kind in ("capsule", "cylinder"):
            result.append((i, kind, (shape.radius(), 0.5 * shape.length())))
        elif around is not None:
            result.append((i, "box", tuple(map(float, around.half_width()))))
        else:  # of a half space there is no box
            result.append((i, "plane", (0.0, 0.0, 1.0, 0.0)))
    return result


def _poses(query: Any, geometries: list[Any]) -> np.ndarray:
    poses = []
    for each in geometries:
        around = query.inspector().GetObbInGeometryFrame(each)
        pose = query.GetPoseInWorld(each) if around is None else query.GetPoseInWorld(each) @ around.pose()
        poses.append([*pose.translation(), *pose.rotation().matrix().ravel()])
    return np.reshape(poses, (-1, 12))


def capture(plant: Any, context: Any, *, name: str = "drake") -> Step:
    """The contacts of the step that a discrete plant takes next from its context, and what else holds its joints.

    A hydroelastic contact becomes one point contact for each face of its surface. Drake's own forces at these points
    are not known, so that the step then has no impulses.

    Bounded rows of the problem are limits and locks of joints, coupler, distance, ball and weld constraints, and the PD
    controllers of actuators with their effort limits. Those that Drake keeps nearly rigid hold exactly in the velocity,
    without its correction of their error, and an open limit may close within the step. A PD controller acts at the
    velocity after the step, and a distance constraint of finite stiffness does at the length then: both are offset and
    compliance of their rows. Forces that no row can have are a line of the step's `notes`, with how many coordinates they
    push: they act as Drake found them.

    Args:
        plant: a finalized MultibodyPlant with a time step, connected to a SceneGraph.
        context: its own context, in a diagram's: plant.GetMyContextFromRoot(root).
        name: of the problem.

    Returns:
        A `Step` with the velocity after Drake's own step, its impulses where all contacts are points, and for pictures
        the poses of `shapes(plant, context)`. Of bounded rows Drake tells the impulses of PD controllers alone; others are
        those between their bounds that explain the velocity, one choice where rows repeat each other.

    Raises:
        InputError: the plant is continuous, or its output ports are sampled: it needs SetUseSampledOutputPorts(False).
    """
    from pydrake.multibody.plant import CalcContactFrictionFromSurfaceProperties, CoulombFriction
    from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex

    h, nv = plant.time_step(), plant.num_velocities()
    if not h > 0:
        raise InputError("plant: is continuous, expected a discrete one")
    if plant.has_sampled_output_ports():
        raise InputError("plant: its output ports show the step before; call plant.SetUseSampledOutputPorts(False) "
                         "before Finalize()")
    world, v = plant.world_frame(), plant.GetVelocities(context)
    query, geometries = _geometries(plant, context)
    inspector = query.inspector()

    def jacobian(body: Any, point: np.ndarray) -> np.ndarray:
        local = body.EvalPoseInWorld(context).inverse() @ point
        return np.array(plant.CalcJacobianTranslationalVelocity(
            context, JacobianWrtVariable.kV, body.body_frame(), local, world, world))

    def friction(id_a: Any, id_b: Any) -> float:
        each = [inspector.GetProximityProperties(geometry) for geometry in (id_a, id_b)]
        found = [p.GetProperty("material", "coulomb_friction") if p.HasProperty("material", "coulomb_friction")
                 else CoulombFriction(1.0, 1.0) for p in each]
        return float(CalcContactFrictionFromSurfaceProperties(*found).dynamic_friction())

    def named(id_a: Any, id_b: Any) -> str:
        return f"{inspector.GetName(id_a)} on {inspector.GetName(id_b)}"

    results = plant.get_contact_results_output_port().Eval(context)
    normals, tangents, mu, gap, ids, places, normal, along = [], [], [], [], [], [], [], []

    def add(body_a: Any, body_b: Any, point: np.ndarray, n: np.ndarray, coefficient: float, distance: float,
            text: str) -> np.ndarray:
        J = jacobian(body_a, point) - jacobian(body_b, point)
        t = _any_tangent(n, "contact")
        frame = np.array([n, t, np.cross(n, t)])
        rows = frame @ J
        normals.append(rows[0])
        tangents.extend(rows[1:])
        mu.append(coefficient)
        gap.append(distance)
        ids.append(text)
        places.append([*point, *n, *t])
        return frame

    for i in range(results.num_point_pair_contacts()):
        info = results.point_pair_contact_info(i)
        pair, bodies = info.point_pair(), [plant.get_body(k) for k in (info.bodyA_index(), info.bodyB_index())]
        frame = add(bodies[0], bodies[1], np.array(info.contact_point()), np.array(pair.nhat_BA_W),
                    friction(pair.id_A, pair.id_B), -float(pair.depth), named(pair.id_A, pair.id_B))
        on_a = -h * frame @ np.array(info.contact_force())
        normal.append(on_a[0])
        along.append(on_a[1:])
    for i in range(results.num_hydroelastic_contacts()):
        surface = results.hydroelastic_contact_info(i).contact_surface()
        touching = surface.id_M(), surface.id_N()
        frames = [inspector.GetFrameId(each) for each in touching]
        pair_of = [plant.GetBodyFromFrameId(each) for each in frames]
        coefficient = friction(*touching)
        for face in range(surface.num_faces()):
            add(pair_of[0], pair_of[1], np.array(surface.centroid(face)), np.array(surface.face_normal(face)),
                coefficient, 0.0, named(*touching))
    M = np.array(plant.CalcMassMatrix(context))
    G = 0.5 * (M + M.T)
    if not _is_tamsi(plant):  # whose damping is explicit
        G += h * np.diag(_joint_damping(plant, context))
    total = np.zeros(nv)
    for k in range(plant.num_model_instances()):
        instance = ModelInstanceIndex(k)
        if plant.num_velocities(instance) > 0:
            force = plant.get_generalized_contact_forces_output_port(instance).Eval(context)
            plant.SetVelocitiesInArray(instance, force, total)
    after = v + h * np.array(plant.get_generalized_acceleration_output_port().Eval(context))
    rows, notes = Rows(nv), []
    actuation = np.array(plant.get_net_actuation_output_port().Eval(context))
    known = _add_joints(plant, context, actuation, after, rows)
    unknown = _add_constraints(plant, context, rows)
    push = h * _forces(plant, context, actuation)
    left = G @ (after - v) - push - h * total  # what rows have to explain
    row_impulses = rows.explained(left, known)
    left -= rows.R @ row_impulses
    found = np.abs(left) > 1e-5 * np.max([np.abs(G @ v), np.abs(push), np.abs(h * total)], axis=0, initial=0.0).max(initial=1e-9)
    if unknown:
        notes.append(f"constraints of kinds that are not known here, as the forces that Drake found: {unknown}")
    if found.any():
        notes.append(f"coordinates on which other forces act as Drake found them: {np.count_nonzero(found)}")
    free = v + np.linalg.solve(G, push + left) if nv else after
    count = len(normals)
    problem = Problem(G=G, N=np.reshape(normals, (count, nv)).T, tangents=np.reshape(tangents, (2 * count, nv)).T,
                      mu=np.array(mu), v=free, b=np.maximum(gap, 0) / h, rows=rows.fields(), name=name)
    impulses = None
    if len(normal) == count:
        impulses = np.column_stack([normal, np.reshape(along, (-1, 2)) * (problem.mu > 0)[:, None]])
    return Step(problem, time=float(context.get_time()), gap=np.array(gap), contact_ids=numbered(ids), impulses=impulses,
                row_impulses=row_impulses if len(rows) else None, velocity=after, poses=_poses(query, geometries),
                contact_frames=places, notes=notes)
