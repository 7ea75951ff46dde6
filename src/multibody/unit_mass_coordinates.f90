!> Deflections of exact beams in coordinates with unit mass. The coordinates of a body are condensed there with a mass matrix that
!> is the identity. That of an exact beam, M = L L^T, becomes it in the coordinates L^T eta: couplings, rows and forces are
!> multiplied by L^-1, the accelerations by L^-T; nothing else of the solution changes. Floor: multibody. Source: doc/theory, eq.
!> (2.41).
module limber_multibody_unit_mass_coordinates
   use limber_base_kinds, only: wp
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: update_eta_masses, factor_eta_masses, to_unit_mass, from_unit_mass

contains

   !> Mass matrices of the coordinates of exact beams at the placed kinematics.
   pure subroutine update_eta_masses(work)
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(work%kinematics%beams)
         call work%kinematics%lines(i)%eta_mass(work%bodies(work%kinematics%beams(i))%eta_mass)
      end do
   end subroutine update_eta_masses

   !> The same, and their factors.
   subroutine factor_eta_masses(work, singular)
      type(workspace_type), intent(inout) :: work
      !> True if one of them has none
      logical, intent(out) :: singular
      integer :: i
      call update_eta_masses(work)
      singular = .false.
      do i = 1, size(work%kinematics%beams)
         associate (body => work%bodies(work%kinematics%beams(i)))
            call factor_mass(size(body%factor, 1), body%eta_mass, body%factor, singular)
         end associate
      end do
   end subroutine factor_eta_masses

   !> Cholesky factor, in the lower triangle.
   pure subroutine factor_mass(n, mass, factor, singular)
      integer, intent(in) :: n
      real(wp), intent(in) :: mass(n, n)
      real(wp), intent(inout) :: factor(n, n)
      logical, intent(inout) :: singular
      integer :: i, j, k
      do j = 1, n
         factor(j:, j) = mass(j:, j)
         do k = 1, j - 1
            do i = j, n
               factor(i, j) = factor(i, j) - factor(i, k)*factor(j, k)
            end do
         end do
         if (.not. factor(j, j) > 1.0e-14_wp*mass(j, j)) then
            singular = .true.
            return
         end if
         factor(j, j) = sqrt(factor(j, j))
         factor(j + 1:, j) = factor(j + 1:, j)/factor(j, j)
      end do
   end subroutine factor_mass

   !> L^-1 x in the place of x.
   pure subroutine to_unit_mass(factor, x)
      !> (n, n), (n)
      real(wp), contiguous, intent(in) :: factor(:, :)
      real(wp), intent(inout) :: x(:)
      integer :: i, j
      do j = 1, size(x)
         x(j) = x(j)/factor(j, j)
         do i = j + 1, size(x)
            x(i) = x(i) - factor(i, j)*x(j)
         end do
      end do
   end subroutine to_unit_mass

   !> L^-T x in the place of x.
   pure subroutine from_unit_mass(factor, x)
      !> (n, n), (n)
      real(wp), contiguous, intent(in) :: factor(:, :)
      real(wp), intent(inout) :: x(:)
      integer :: i, j
      do j = size(x), 1, -1
         do i = j + 1, size(x)
            x(j) = x(j) - factor(i, j)*x(i)
         end do
         x(j) = x(j)/factor(j, j)
      end do
   end subroutine from_unit_mass

end module limber_multibody_unit_mass_coordinates
