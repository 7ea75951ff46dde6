!> Products of tangent blocks with vectors. Floor: multibody.
module limber_multibody_tangent_products
   use limber_base_kinds, only: wp
   use limber_multibody_system, only: system_type
   use limber_multibody_tangent, only: tangent_type
   implicit none
   private
   public :: times_mass, times_damping, times_stiffness

contains

   !> product = product + factor M vector.
   subroutine times_mass(system, tangent, factor, vector, product)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw)
      real(wp), intent(in) :: factor, vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: i
      do i = 1, size(tangent%bodies)
         call add_own(tangent%bodies(i)%mass, system%layout%w(i), factor, vector, product)
      end do
   end subroutine times_mass

   !> product = product + factor D vector.
   subroutine times_damping(system, tangent, factor, vector, product)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw)
      real(wp), intent(in) :: factor, vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: i
      do i = 1, size(tangent%bodies)
         call add_own(tangent%bodies(i)%damping, system%layout%w(i), factor, vector, product)
      end do
      do i = 1, size(tangent%loads)
         call add_spread(tangent%loads(i)%damping, tangent%loads(i)%unknowns, factor, vector, product)
      end do
   end subroutine times_damping

   !> product = product + factor K vector.
   subroutine times_stiffness(system, tangent, factor, vector, product)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw)
      real(wp), intent(in) :: factor, vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: i, j, first, other
      do i = 1, size(tangent%bodies)
         call add_own(tangent%bodies(i)%stiffness, system%layout%w(i), factor, vector, product)
      end do
      do i = 1, size(tangent%constraints)
         associate (across => tangent%constraints(i)%across, bodies => system%constraints(i)%item%bodies)
            if (size(across) == 0) cycle
            first = system%layout%w(bodies(1))
            other = system%layout%w(bodies(2))
            do j = 1, size(across, 2)
               product(first:first + size(across, 1) - 1) = product(first:first + size(across, 1) - 1) &
                  & + factor*vector(other + j - 1)*across(:, j)
               product(other + j - 1) = product(other + j - 1) &
                  & + factor*dot_product(across(:, j), vector(first:first + size(across, 1) - 1))
            end do
         end associate
      end do
      do i = 1, size(tangent%loads)
         call add_spread(tangent%loads(i)%stiffness, tangent%loads(i)%unknowns, factor, vector, product)
      end do
   end subroutine times_stiffness

   !> Adds the product of a body's own block.
   pure subroutine add_own(block, first, factor, vector, product)
      !> (m, m)
      real(wp), intent(in) :: block(:, :)
      !> Its first unknown
      integer, intent(in) :: first
      real(wp), intent(in) :: factor, vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: j, last
      last = first + size(block, 1) - 1
      do j = 1, size(block, 2)
         product(first:last) = product(first:last) + factor*vector(first + j - 1)*block(:, j)
      end do
   end subroutine add_own

   !> Adds the product of a load's block.
   pure subroutine add_spread(block, unknowns, factor, vector, product)
      !> (m, m)
      real(wp), intent(in) :: block(:, :)
      !> (m)
      integer, intent(in) :: unknowns(:)
      real(wp), intent(in) :: factor, vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: j, k
      do j = 1, size(unknowns)
         do k = 1, size(unknowns)
            product(unknowns(k)) = product(unknowns(k)) + factor*block(k, j)*vector(unknowns(j))
         end do
      end do
   end subroutine add_spread

end module limber_multibody_tangent_products
