// Calls a function of Bullet's libraries that has btScalar in its signature, and so in its name
// for the linker. See tests/precision.rs.
#include <btBulletDynamicsCommon.h>

int main() { return btCapsuleShape(1, 2).getUpAxis() - 1; }
