!> Axial functions: static responses to forces along a beam. Static responses to forces along the beam and to a centrifugal load,
!> which carry the tension of the model k_g at once. They are made orthonormal in the lumped mass and diagonalise the axial
!> stiffness. Floor: beam. Source: doc/theory, eq. (2.11).
module limber_beam_axial_functions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev
   use limber_base_text, only: as_text
   use limber_beam_beam_mesh, only: beam_type, support_type, displacement_field_type, nodal_masses
   implicit none
   private
   public :: static_functions, axial_basis

contains

   !> Strains (elements, number) of the static functions: the responses to forces along the beam at places of it, to one at its end,
   !> and to a load that grows with the distance from a place, as that of a rotation does.
   pure function static_functions(x, origin, places, support) result(strain)
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      !> Where that load is zero [length]
      real(wp), intent(in) :: origin
      !> Places where forces along the beam act [length]; of a beam that nothing holds they accelerate it
      real(wp), intent(in) :: places(:)
      type(support_type), intent(in) :: support
      real(wp) :: strain(size(x) - 1, size(places) + 2)
      real(wp) :: length
      integer :: n, i
      n = size(x) - 1
      length = x(n)
      do i = 1, size(places)
         ! Part of each element before the place, pulled by a unit force
         strain(:, i) = min(max(places(i) - x(0:n - 1), 0.0_wp), x(1:n) - x(0:n - 1))/(x(1:n) - x(0:n - 1))
         if (.not. (support%u_start .or. support%u_end)) strain(:, i) = strain(:, i) - 1 + (x(1:n) + x(0:n - 1))/(2*length)
      end do
      i = size(places) + 1
      strain(:, i) = 1.0_wp
      ! mean over the element of the tension, the integral of (s - origin) from s to the free end
      strain(:, i + 1) = (length**2/2 - origin*length) &
         & - (x(1:n)**2 + x(1:n)*x(0:n - 1) + x(0:n - 1)**2)/6 + origin*(x(1:n) + x(0:n - 1))/2
      strain(:, i + 1) = strain(:, i + 1)/length**2
   end function static_functions

   !> Turns strains into axial coordinates of the beam: displacements that respect the supports, orthonormal in
   !> the lumped mass, with a diagonal stiffness. Functions that depend on those before them are left out.
   subroutine axial_basis(beam, support, x, wanted, field, strain, error, left_out)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      !> Strains to be carried (elements, number), any scaling
      real(wp), intent(in) :: wanted(:, :)
      !> Receives u and the axial frequencies
      type(displacement_field_type), intent(inout) :: field
      !> Strains of the coordinates made (elements, number)
      real(wp), allocatable, intent(out) :: strain(:, :)
      type(error_type), allocatable, intent(out) :: error
      !> Increased by the number of functions that depend on others
      integer, intent(inout), optional :: left_out
      real(wp) :: mass(0:beam%elements), u(0:beam%elements, size(wanted, 2)), e(size(wanted, 1), size(wanted, 2))
      real(wp) :: norm, part
      real(wp), allocatable :: stiffness(:, :), omega2(:), work(:)
      integer :: j, k, kept, pass, info, dependent
      if (size(x) - 1 > beam%elements) then
         call raise(error, as_text(size(x) - 1)//' k_G elements need at least as many elements for their axial functions, not '// &
            & as_text(beam%elements))
         return
      end if
      mass = nodal_masses(beam)
      kept = 0
      dependent = 0
      do j = 1, size(wanted, 2)
         e(:, kept + 1) = wanted(:, j)
         call respect_supports(support, x, e(:, kept + 1))
         u(:, kept + 1) = displacement(field%s, x, e(:, kept + 1))
         if (.not. (support%u_start .or. support%u_end)) &
            & u(:, kept + 1) = u(:, kept + 1) - sum(mass*u(:, kept + 1))/sum(mass)
         norm = sqrt(sum(mass*u(:, kept + 1)**2))
         if (.not. norm > 1.0e-12_wp*sqrt(sum(mass))*beam%length*maxval(abs(wanted(:, j)))) then
            if (maxval(abs(wanted(:, j))) > 0.0_wp) dependent = dependent + 1
            cycle
         end if
         u(:, kept + 1) = u(:, kept + 1)/norm
         e(:, kept + 1) = e(:, kept + 1)/norm
         do pass = 1, 2
            do k = 1, kept
               part = sum(mass*u(:, k)*u(:, kept + 1))
               u(:, kept + 1) = u(:, kept + 1) - part*u(:, k)
               e(:, kept + 1) = e(:, kept + 1) - part*e(:, k)
            end do
         end do
         norm = sqrt(sum(mass*u(:, kept + 1)**2))
         if (norm < 1.0e-7_wp) then
            dependent = dependent + 1
            cycle
         end if
         u(:, kept + 1) = u(:, kept + 1)/norm
         e(:, kept + 1) = e(:, kept + 1)/norm
         kept = kept + 1
      end do
      if (present(left_out)) left_out = left_out + dependent
      allocate (stiffness(kept, kept), omega2(kept), work(max(1, 8*kept)))
      do j = 1, kept
         do k = 1, kept
            stiffness(k, j) = beam%ea*sum((x(1:) - x(:ubound(x, 1) - 1))*e(:, k)*e(:, j))
         end do
      end do
      call dsyev('V', 'L', kept, stiffness, max(1, kept), omega2, work, size(work), info)
      if (info /= 0) then
         call raise(error, 'the axial functions could not be made orthogonal (LAPACK info '//as_text(info)//')')
         return
      end if
      field%omega2_axial = omega2
      deallocate (field%u)
      allocate (field%u(0:beam%elements, kept))
      field%u(:, :) = matmul(u(:, :kept), stiffness)
      strain = matmul(e(:, :kept), stiffness)
   end subroutine axial_basis

   !> Takes the mean out of the strain where both ends are held.
   pure subroutine respect_supports(support, x, strain)
      type(support_type), intent(in) :: support
      real(wp), intent(in) :: x(0:)
      real(wp), intent(inout) :: strain(:)
      integer :: n
      n = size(strain)
      if (support%u_start .and. support%u_end) strain = strain - sum((x(1:n) - x(0:n - 1))*strain)/x(n)
   end subroutine respect_supports

   !> Displacement at the nodes s from strains constant over each element: zero at the start.
   pure function displacement(s, x, strain) result(u)
      real(wp), intent(in) :: s(0:), x(0:), strain(:)
      real(wp) :: u(0:size(s) - 1)
      integer :: i, g
      do i = 0, size(s) - 1
         u(i) = 0.0_wp
         do g = 1, size(strain)
            u(i) = u(i) + strain(g)*min(max(s(i) - x(g - 1), 0.0_wp), x(g) - x(g - 1))
         end do
      end do
   end function displacement

end module limber_beam_axial_functions
