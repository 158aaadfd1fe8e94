"""Contacts of a discrete MultibodyPlant of Drake (PyPI's `drake`).

    plant.SetUseSampledOutputPorts(False)  # before plant.Finalize()
    ...
    step = lcpbench.drake.capture(plant, plant.GetMyContextFromRoot(simulator.get_context()))
    answer = lcpbench.solve(step.problem)

Drake softens contacts on purpose. The problem is that of hard contacts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._files import Step, numbered
from ._native import InputError
from ._problem import Problem, _any_tangent

__all__ = ["capture", "shapes"]


def _joint_damping(plant: Any, context: Any) -> np.ndarray:
    damping = np.zeros(plant.num_velocities())
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities() > 0:
            first = joint.velocity_start()
            damping[first : first + joint.num_velocities()] = joint.GetDampingVector(context)
    return damping


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
    """The contacts of the step that a discrete plant takes next from its context.

    A hydroelastic contact becomes one point contact for each face of its surface. Drake's own forces at these points
    are not known, so that the step then has no impulses. Limits of joints and other constraints act as the forces that
    Drake found.

    Args:
        plant: a finalized MultibodyPlant with a time step, connected to a SceneGraph.
        context: its own context, in a diagram's: plant.GetMyContextFromRoot(root).
        name: of the problem.

    Returns:
        A `Step` with the velocity after Drake's own step, its impulses where all contacts are points, and for pictures
        the poses of `shapes(plant, context)`.

    Raises:
        InputError: the plant is continuous, or its output ports are sampled: it needs SetUseSampledOutputPorts(False).
    """
    from pydrake.multibody.plant import (CalcContactFrictionFromSurfaceProperties, CoulombFriction,
                                         DiscreteContactApproximation)
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
    if plant.get_discrete_contact_approximation() != DiscreteContactApproximation.kTamsi:  # TAMSI's damping is explicit
        G += h * np.diag(_joint_damping(plant, context))
    total = np.zeros(nv)
    for k in range(plant.num_model_instances()):
        instance = ModelInstanceIndex(k)
        if plant.num_velocities(instance) > 0:
            force = plant.get_generalized_contact_forces_output_port(instance).Eval(context)
            plant.SetVelocitiesInArray(instance, force, total)
    after = v + h * np.array(plant.get_generalized_acceleration_output_port().Eval(context))
    free = after - h * np.linalg.solve(G, total) if nv else after
    count = len(normals)
    problem = Problem(G=G, N=np.reshape(normals, (count, nv)).T, tangents=np.reshape(tangents, (2 * count, nv)).T,
                      mu=np.array(mu), v=free, b=np.maximum(gap, 0) / h, name=name)
    impulses = None
    if len(normal) == count:
        impulses = np.column_stack([normal, np.reshape(along, (-1, 2)) * (problem.mu > 0)[:, None]])
    return Step(problem, time=float(context.get_time()), gap=np.array(gap), contact_ids=numbered(ids), impulses=impulses,
                velocity=after, poses=_poses(query, geometries), contact_frames=places)
