!> Axial functions for the full model, made of constant strain over each k_G element: one for each element, or a
!> few chosen ones (static responses to an end force and to a centrifugal load, and modal derivatives).
!>
!> They must live on the same k_G elements as the coupling: with vibration modes alone, or with functions on a finer
!> mesh than the element means, the model locks. They are made orthonormal in the lumped mass and diagonalise
!> the axial stiffness. Floor: flex. Source: doc/theory, eqs. (25), (26).
module limber_flex_axial
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev
   use limber_base_text, only: as_text
   use limber_flex_mesh, only: beam_type, support_type, field_type, nodal_masses
   implicit none
   private
   public :: element_functions, static_functions, axial_basis

contains

   !> Strains (elements, elements) of one function for each k_G element.
   pure function element_functions(elements) result(strain)
      integer, intent(in) :: elements
      real(wp) :: strain(elements, elements)
      integer :: g
      strain = 0.0_wp
      do g = 1, elements
         strain(g, g) = 1.0_wp
      end do
   end function element_functions

   !> Strains (elements, number) of the chosen static functions.
   pure function static_functions(x, b, origin, end_force, centrifugal, derivatives, places, support) result(strain)
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      !> Mean squared slopes of the bending coordinates (bending, bending, elements)
      real(wp), intent(in) :: b(:, :, :)
      !> Place along the beam that the centrifugal load is proportional to the distance from [length]
      real(wp), intent(in) :: origin
      !> Response to an end force: uniform strain
      logical, intent(in) :: end_force
      !> Response to a load that grows from `origin`
      logical, intent(in) :: centrifugal
      !> Number of modal derivatives, for the pairs (1,1), (1,2), (2,2), (1,3), ... of bending coordinates: the
      !> strain that cancels the foreshortening of the pair, -1/2 mean(phi_i' phi_j')
      integer, intent(in) :: derivatives
      !> Places where forces along the beam act [length]; of a beam that nothing holds they accelerate it
      real(wp), intent(in), optional :: places(:)
      type(support_type), intent(in), optional :: support
      real(wp), allocatable :: strain(:, :)
      real(wp) :: length
      integer :: n, count, i, j, made
      n = size(x) - 1
      length = x(n)
      count = 0
      if (present(places)) count = size(places)
      count = count + merge(1, 0, end_force) + merge(1, 0, centrifugal) + min(derivatives, size(b, 1)*(size(b, 1) + 1)/2)
      allocate (strain(n, count))
      made = 0
      if (present(places)) then
         do i = 1, size(places)
            made = made + 1
            ! Part of each element before the place, pulled by a unit force
            strain(:, made) = min(max(places(i) - x(0:n - 1), 0.0_wp), x(1:n) - x(0:n - 1))/(x(1:n) - x(0:n - 1))
            if (present(support)) then
               if (.not. (support%u_start .or. support%u_end)) strain(:, made) = strain(:, made) - 1 &
                  & + (x(1:n) + x(0:n - 1))/(2*length)
            end if
         end do
      end if
      if (end_force) then
         made = made + 1
         strain(:, made) = 1.0_wp
      end if
      if (centrifugal) then
         made = made + 1
         ! mean over the element of the tension, the integral of (s - origin) from s to the free end
         strain(:, made) = (length**2/2 - origin*length) &
            & - (x(1:n)**2 + x(1:n)*x(0:n - 1) + x(0:n - 1)**2)/6 + origin*(x(1:n) + x(0:n - 1))/2
         strain(:, made) = strain(:, made)/length**2
      end if
      do j = 1, size(b, 1)
         do i = 1, j
            if (made == count) return
            made = made + 1
            strain(:, made) = -0.5_wp*b(i, j, :)
         end do
      end do
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
      type(field_type), intent(inout) :: field
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

end module limber_flex_axial
