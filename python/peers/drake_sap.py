#!/usr/bin/env python3
"""A step of Drake's discrete engine with its solver SAP: drake_sap.py [THRESHOLD], with form=scene,cone=true.

The bodies become free bodies of a MultibodyPlant. Each contact becomes two small balls that touch at its point and meet
no other geometry. SAP solves a convex model, in which what slides lifts off, and softens contacts on purpose: THRESHOLD
is the plant's sap_near_rigid_threshold, 1 in Drake; less is stiffer, 0.01 unless given. The step takes 1 us, so that no
force but those of contacts counts. Drake's step knows no gaps and no restitution: contacts with an offset are refused.
"""
import sys

import numpy as np
from peer import Contacts, serve, timed
from pydrake.geometry import (AddContactMaterial, CollisionFilterDeclaration, GeometrySet, ProximityProperties, Sphere)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.framework import DiagramBuilder

threshold = float(sys.argv[1]) if len(sys.argv) > 1 else 0.01
STEP, RADIUS, DEPTH = 1e-6, 0.01, 1e-12


def load(text):
    problem = Contacts.of_scene(text)
    if np.any(problem.b != 0):
        return "contacts have offsets: Drake's step knows no gaps and no restitution"
    builder = DiagramBuilder()
    plant, graph = AddMultibodyPlant(MultibodyPlantConfig(
        time_step=STEP, contact_model="point", discrete_contact_approximation="sap", sap_near_rigid_threshold=threshold,
        use_sampled_output_ports=False), builder)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    bodies = [plant.AddRigidBody(f"{i}", SpatialInertia(each["mass"], [0, 0, 0], UnitInertia(
        *np.array(each["inertia"])[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] / each["mass"])))
              for i, each in enumerate(text["bodies"])]
    pairs, places = [[] for _ in range(problem.nc)], {}
    for i, side, k, at in problem.balls(RADIUS, np.full(problem.nc, DEPTH)):
        properties = ProximityProperties()
        AddContactMaterial(point_stiffness=1e20, friction=CoulombFriction(problem.mu[i], problem.mu[i]),
                           properties=properties)
        pairs[i].append(plant.RegisterCollisionGeometry(bodies[k] if k >= 0 else plant.world_body(), RigidTransform(at),
                                                        Sphere(RADIUS), f"{i} {side}", properties))
        places[pairs[i][-1].get_value()] = i, side
    plant.Finalize()
    allowed = CollisionFilterDeclaration().ExcludeWithin(GeometrySet([each for pair in pairs for each in pair]))
    for a, b in pairs:
        allowed.AllowBetween(GeometrySet(a), GeometrySet(b))
    graph.collision_filter_manager().Apply(allowed)
    context = plant.GetMyContextFromRoot(builder.Build().CreateDefaultContext())
    for i, body in enumerate(bodies):
        plant.SetFreeBodyPose(context, body, RigidTransform(text["bodies"][i]["position"]))
        plant.SetFreeBodySpatialVelocity(body, SpatialVelocity(problem.v[6 * i + 3 : 6 * i + 6],
                                                               problem.v[6 * i : 6 * i + 3]), context)

    def solve(_):
        results = timed(plant.get_contact_results_output_port().Eval, context)
        found = map(results.point_pair_contact_info, range(results.num_point_pair_contacts()))
        return problem.of_engine((*places[each.point_pair().id_B.get_value()], STEP * each.contact_force())  # is on B
                                 for each in found)

    return solve


serve(load)
