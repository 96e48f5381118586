// A world of Box2D v3 from flat arrays of doubles: made, stepped any number of times in one call with or without a
// profile, read, destroyed.
// The same five functions as in box3d.c; ../peers.py declares them and says what the rows mean.

#include "box2d/box2d.h"

#include <math.h>
#include <stdlib.h>

enum
{
	BODY_SIZE = 9,
	SHAPE_SIZE = 9,
	STAGE_COUNT = 20,
	JOINT_SIZE = 10,
};

typedef struct Peer
{
	b2WorldId world;
	int count;
	b2BodyId bodies[];
} Peer;

static b2Vec2 vec( const double* p )
{
	return (b2Vec2){ (float)p[0], (float)p[1] };
}

// gravity (2), contact hertz, damping ratio, speed; joint hertz, damping ratio; sleep, recycling
static b2WorldId makeWorld( const double* w )
{
	b2WorldDef def = b2DefaultWorldDef();
	def.gravity = vec( w );
	def.contactHertz = (float)w[2];
	def.contactDampingRatio = (float)w[3];
	def.contactSpeed = (float)w[4];
	def.restitutionThreshold = 0.0f;
	def.enableSleep = w[7] != 0.0;
	def.enableContinuous = false;
	return b2CreateWorld( &def );
}

// dynamic, x, y, angle, vx, vy, angular velocity, mass, inertia
static b2BodyId makeBody( b2WorldId world, const double* row, bool recycling )
{
	b2BodyDef def = b2DefaultBodyDef();
	def.type = row[0] != 0.0 ? b2_dynamicBody : b2_staticBody;
	def.position.x = row[1];
	def.position.y = row[2];
	def.rotation = (b2Rot){ (float)cos( row[3] ), (float)sin( row[3] ) };
	def.linearVelocity = vec( row + 4 );
	def.angularVelocity = (float)row[6];
	def.allowFastRotation = true;
	def.enableContactRecycling = recycling;
	return b2CreateBody( world, &def );
}

// body, is a box, x, y, angle, half width or radius, half height, friction, restitution
static void makeShape( const b2BodyId* bodies, const double* row )
{
	b2ShapeDef def = b2DefaultShapeDef();
	def.material.friction = (float)row[7];
	def.material.restitution = (float)row[8];
	b2BodyId body = bodies[(int)row[0]];
	if ( row[1] != 0.0 )
	{
		b2Rot rotation = { (float)cos( row[4] ), (float)sin( row[4] ) };
		b2Polygon box = b2MakeOffsetBox( (float)row[5], (float)row[6], vec( row + 2 ), rotation );
		b2CreatePolygonShape( body, &def, &box );
	}
	else
	{
		b2Circle circle = { vec( row + 2 ), (float)row[5] };
		b2CreateCircleShape( body, &def, &circle );
	}
}

static void setBase( b2JointDef* base, const b2BodyId* bodies, const double* row, const double* w )
{
	base->bodyIdA = bodies[(int)row[1]];
	base->bodyIdB = bodies[(int)row[2]];
	base->localFrameA.p = vec( row + 3 );
	base->localFrameB.p = vec( row + 5 );
	base->constraintHertz = (float)w[5];
	base->constraintDampingRatio = (float)w[6];
}

// is a spring, body a, body b, anchor a (2), anchor b (2), length, hertz, damping ratio
static void makeJoint( b2WorldId world, const b2BodyId* bodies, const double* row, const double* w )
{
	if ( row[0] == 0.0 )
	{
		b2RevoluteJointDef def = b2DefaultRevoluteJointDef();
		setBase( &def.base, bodies, row, w );
		b2CreateRevoluteJoint( world, &def );
		return;
	}
	b2DistanceJointDef def = b2DefaultDistanceJointDef();
	setBase( &def.base, bodies, row, w );
	def.length = (float)row[7];
	def.enableSpring = true;
	def.hertz = (float)row[8];
	def.dampingRatio = (float)row[9];
	b2CreateDistanceJoint( world, &def );
}

Peer* peer_create( const double* w, const int* counts, const double* bodies, const double* shapes, const double* joints )
{
	Peer* peer = malloc( sizeof( Peer ) + counts[0] * sizeof( b2BodyId ) );
	peer->world = makeWorld( w );
	peer->count = counts[0];
	for ( int k = 0; k < counts[0]; ++k )
	{
		peer->bodies[k] = makeBody( peer->world, bodies + k * BODY_SIZE, w[8] != 0.0 );
	}
	for ( int k = 0; k < counts[1]; ++k )
	{
		makeShape( peer->bodies, shapes + k * SHAPE_SIZE );
	}
	for ( int k = 0; k < counts[0]; ++k )
	{
		const double* row = bodies + k * BODY_SIZE;
		if ( row[0] != 0.0 )
		{
			b2Body_SetMassData( peer->bodies[k], (b2MassData){ (float)row[7], { 0.0f, 0.0f }, (float)row[8] } );
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
		b2World_Step( peer->world, (float)timestep, substeps );
	}
}

// of each step the ms of its stages by the engine's own clock, in the order of STAGES in ../peers.py
void peer_profile( Peer* peer, double timestep, int substeps, int count, double* out )
{
	for ( int k = 0; k < count; ++k )
	{
		b2World_Step( peer->world, (float)timestep, substeps );
		b2Profile p = b2World_GetProfile( peer->world );
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

// x, y, angle within a turn, vx, vy, angular velocity of each body
void peer_read( const Peer* peer, double* out )
{
	for ( int k = 0; k < peer->count; ++k, out += 6 )
	{
		b2Rot q = b2Body_GetRotation( peer->bodies[k] );
		b2Vec2 v = b2Body_GetLinearVelocity( peer->bodies[k] );
		out[0] = b2Body_GetPosition( peer->bodies[k] ).x;
		out[1] = b2Body_GetPosition( peer->bodies[k] ).y;
		out[2] = atan2( q.s, q.c );
		out[3] = v.x;
		out[4] = v.y;
		out[5] = b2Body_GetAngularVelocity( peer->bodies[k] );
	}
}

void peer_destroy( Peer* peer )
{
	b2DestroyWorld( peer->world );
	free( peer );
}
