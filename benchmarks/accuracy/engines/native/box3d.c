// A world of Box3D from flat arrays of doubles: made, stepped any number of times in one call with or without a
// profile, read, destroyed.
// The same five functions as in box2d_v3.c; ../peers.py declares them and says what the rows mean.

#include "box3d/box3d.h"

#include <stdlib.h>

enum
{
	BODY_SIZE = 18,
	SHAPE_SIZE = 14,
	STAGE_COUNT = 20,
	JOINT_SIZE = 8,
	CYLINDER_SIDES = 32, // the most that b3CreateCylinder takes
};

enum
{
	SPHERE = 0,
	BOX = 1,
	CYLINDER = 2,
};

typedef struct Peer
{
	b3WorldId world;
	int count;
	b3BodyId bodies[];
} Peer;

static b3Vec3 vec( const double* p )
{
	return (b3Vec3){ (float)p[0], (float)p[1], (float)p[2] };
}

// from w, x, y, z
static b3Quat quat( const double* q )
{
	return (b3Quat){ { (float)q[1], (float)q[2], (float)q[3] }, (float)q[0] };
}

// gravity (3), contact hertz, damping ratio, speed; joint hertz, damping ratio; sleep, recycling
static b3WorldId makeWorld( const double* w )
{
	b3WorldDef def = b3DefaultWorldDef();
	def.gravity = vec( w );
	def.contactHertz = (float)w[3];
	def.contactDampingRatio = (float)w[4];
	def.contactSpeed = (float)w[5];
	def.restitutionThreshold = 0.0f;
	def.enableSleep = w[8] != 0.0;
	def.enableContinuous = false;
	return b3CreateWorld( &def );
}

// dynamic, position (3), quaternion (4), velocity (3), angular velocity (3), mass, inertia (3)
static b3BodyId makeBody( b3WorldId world, const double* row, bool recycling )
{
	b3BodyDef def = b3DefaultBodyDef();
	def.type = row[0] != 0.0 ? b3_dynamicBody : b3_staticBody;
	def.position.x = row[1];
	def.position.y = row[2];
	def.position.z = row[3];
	def.rotation = quat( row + 4 );
	def.linearVelocity = vec( row + 8 );
	def.angularVelocity = vec( row + 11 );
	def.allowFastRotation = true;
	def.enableContactRecycling = recycling;
	return b3CreateBody( world, &def );
}

static void setMass( b3BodyId body, const double* row )
{
	b3MassData data = { .mass = (float)row[14] };
	data.inertia.cx.x = (float)row[15];
	data.inertia.cy.y = (float)row[16];
	data.inertia.cz.z = (float)row[17];
	b3Body_SetMassData( body, data );
}

// body, kind, position (3), quaternion (4), half extents (3; of spheres the radius, of cylinders the radius and half the
// height), friction, restitution
static void makeShape( const b3BodyId* bodies, const double* row )
{
	b3ShapeDef def = b3DefaultShapeDef();
	def.baseMaterial.friction = (float)row[12];
	def.baseMaterial.restitution = (float)row[13];
	b3BodyId body = bodies[(int)row[0]];
	b3Transform place = { vec( row + 2 ), quat( row + 5 ) };
	if ( row[1] == SPHERE )
	{
		b3Sphere sphere = { place.p, (float)row[9] };
		b3CreateSphereShape( body, &def, &sphere );
	}
	else if ( row[1] == BOX )
	{
		b3BoxHull box = b3MakeTransformedBoxHull( (float)row[9], (float)row[10], (float)row[11], place );
		b3CreateHullShape( body, &def, &box.base );
	}
	else
	{
		// Its axis is y, ours is z.
		float height = 2.0f * (float)row[10];
		b3HullData* hull = b3CreateCylinder( height, (float)row[9], -0.5f * height, CYLINDER_SIDES );
		b3Quat upright = { { 0.70710678f, 0.0f, 0.0f }, 0.70710678f };
		b3Transform turned = { place.p, b3MulQuat( place.q, upright ) };
		b3CreateTransformedHullShape( body, &def, hull, turned, (b3Vec3){ 1.0f, 1.0f, 1.0f } );
		b3DestroyHull( hull );
	}
}

// body a, body b, anchor a (3), anchor b (3): a ball joint
static void makeJoint( b3WorldId world, const b3BodyId* bodies, const double* row, const double* w )
{
	b3SphericalJointDef def = b3DefaultSphericalJointDef();
	def.base.bodyIdA = bodies[(int)row[0]];
	def.base.bodyIdB = bodies[(int)row[1]];
	def.base.localFrameA.p = vec( row + 2 );
	def.base.localFrameB.p = vec( row + 5 );
	def.base.constraintHertz = (float)w[6];
	def.base.constraintDampingRatio = (float)w[7];
	b3CreateSphericalJoint( world, &def );
}

Peer* peer_create( const double* w, const int* counts, const double* bodies, const double* shapes, const double* joints )
{
	Peer* peer = malloc( sizeof( Peer ) + counts[0] * sizeof( b3BodyId ) );
	peer->world = makeWorld( w );
	peer->count = counts[0];
	for ( int k = 0; k < counts[0]; ++k )
	{
		peer->bodies[k] = makeBody( peer->world, bodies + k * BODY_SIZE, w[9] != 0.0 );
	}
	for ( int k = 0; k < counts[1]; ++k )
	{
		makeShape( peer->bodies, shapes + k * SHAPE_SIZE );
	}
	for ( int k = 0; k < counts[0]; ++k )
	{
		if ( bodies[k * BODY_SIZE] != 0.0 )
		{
			setMass( peer->bodies[k], bodies + k * BODY_SIZE );
		}
	}
	for ( int k = 0; k < counts[2]; ++k )
	{
		makeJoint( peer->world, peer->bodies, joints + k * JOINT_SIZE, w );
	}
	return peer;
}

void peer_step( Peer* peer, double timestep, int substeps, int count )
{
	for ( int k = 0; k < count; ++k )
	{
		b3World_Step( peer->world, (float)timestep, substeps );
	}
}

// of each step the ms of its stages by the engine's own clock, in the order of STAGES in ../peers.py
void peer_profile( Peer* peer, double timestep, int substeps, int count, double* out )
{
	for ( int k = 0; k < count; ++k )
	{
		b3World_Step( peer->world, (float)timestep, substeps );
		b3Profile p = b3World_GetProfile( peer->world );
		float stages[STAGE_COUNT] = {
			p.step, p.pairs, p.collide, p.solverSetup, p.prepareConstraints,
			p.integrateVelocities, p.warmStart, p.solveImpulses, p.integratePositions, p.relaxImpulses,
			p.applyRestitution, p.storeImpulses, p.transforms, p.jointEvents, p.hitEvents,
			p.refit, p.bullets, p.sensorHits, p.sleepIslands, p.sensors,
		};
		for ( int i = 0; i < STAGE_COUNT; ++i )
		{
			*out++ = stages[i];
		}
	}
}

// position (3), quaternion (w, x, y, z), velocity (3), angular velocity (3) of each body
void peer_read( const Peer* peer, double* out )
{
	for ( int k = 0; k < peer->count; ++k, out += 13 )
	{
		b3Pos p = b3Body_GetPosition( peer->bodies[k] );
		b3Quat q = b3Body_GetRotation( peer->bodies[k] );
		b3Vec3 v = b3Body_GetLinearVelocity( peer->bodies[k] );
		b3Vec3 w = b3Body_GetAngularVelocity( peer->bodies[k] );
		double row[13] = { p.x, p.y, p.z, q.s, q.v.x, q.v.y, q.v.z, v.x, v.y, v.z, w.x, w.y, w.z };
		for ( int i = 0; i < 13; ++i )
		{
			out[i] = row[i];
		}
	}
}

void peer_destroy( Peer* peer )
{
	b3DestroyWorld( peer->world );
	free( peer );
}
