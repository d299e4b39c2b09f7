// Contact points, read from the dispatcher's manifolds: Bullet's global callbacks would be shared
// between worlds.
#include "state.h"
#include "world.h"

namespace itarl {

std::size_t World::contact_count() const noexcept {
  state_->settle();
  btCollisionDispatcher& dispatcher = state_->dispatcher;
  std::size_t count = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    count += static_cast<std::size_t>(
        dispatcher.getManifoldByIndexInternal(i)->getNumContacts());
  }
  return count;
}

void World::read_contacts(rust::Slice<Contact> out) const {
  if (out.size() != contact_count()) {
    Call{"read_contacts"}.refuse("out", std::to_string(contact_count()) + " entries long",
                                 std::to_string(out.size()));
  }
  std::size_t next = 0;
  for (int i = 0; i < state_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *state_->dispatcher.getManifoldByIndexInternal(i);
    const BodyId a{slot_of(*manifold.getBody0())};
    const BodyId b{slot_of(*manifold.getBody1())};
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      const btVector3 friction = point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                                 point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
      out[next++] = Contact{a,
                            b,
                            to_array(point.m_positionWorldOnB),
                            to_array(point.m_normalWorldOnB),
                            point.m_distance1,
                            point.m_appliedImpulse,
                            to_array(friction)};
    }
  }
}

}  // namespace itarl
