!> The reduction of a beam: invariants against sums over the nodes, and how
!> many modes of each kind are the lowest.
program test_reduction
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_beam_mesh, only: axial_modes, beam_type, bending_modes, displacement_field_type, mesh_beam, new_support, &
      & nodal_masses, &
      & support_type
   use limber_beam_reduced_body, only: reduced_type, rigid_reduced
   use limber_beam_beam_reduction, only: available_modes, fidelity_kg, fidelity_linear, point_shape, &
      & reduce_beam, reduction_type
   use scenes, only: derivative, random
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   type(beam_type), parameter :: rod = beam_type(ea=5.65e6_wp, ei=12.7_wp, rho_a=0.2225_wp, length=0.3_wp, elements=24)
   character(15), parameter :: names(7) = [character(15) :: 'PINNED-ROLLER', 'PINNED-PINNED', 'CLAMPED-FREE', &
      & 'CLAMPED-ROLLER', 'CLAMPED-PINNED', 'CLAMPED-CLAMPED', 'FREE-FREE']
   integer :: i

   do i = 1, size(names)
      call test_invariants(trim(names(i)))
   end do
   call test_lowest()
   call test_too_many()
   call test_point_shape()
   call test_rigid()
   call finish()

contains

   !> Invariants against sums over the nodes written here; the coordinates are orthonormal in the mass as a whole.
   subroutine test_invariants(name)
      character(*), intent(in) :: name
      real(wp), parameter :: origin = 0.11_wp
      integer, parameter :: fidelities(2) = [fidelity_linear, fidelity_kg]
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp), allocatable :: phi(:, :, :), mass(:)
      real(wp) :: product(3), p(2), own(7), scale
      integer :: basis, i, j, k
      do basis = 1, 2
         choice = reduction_type(support=new_support(name), bending=4, axial=3, geometric_elements=6, origin=origin, &
            & fidelity=fidelities(basis))
         call reduce_beam(rod, choice, body, field, error)
         call check_no_error(error, name)
         call check(body%bending == 4 .and. body%n == 4 + size(field%u, 2), name//': number of coordinates')
         call check(body%geometric .eqv. basis > 1, name//': tension acts on the bending')
         allocate (phi(2, body%n, 0:rod%elements), mass(0:rod%elements))
         mass = rod%rho_a*rod%length/rod%elements
         mass([0, rod%elements]) = mass([0, rod%elements])/2
         phi = 0.0_wp
         phi(2, :4, :) = transpose(field%w)
         phi(1, 5:, :) = transpose(field%u)
         call check_close(body%mass, rod%rho_a*rod%length, 1.0e-15_wp, name//': mass')
         own(1) = sum(mass*(field%s - origin))
         call check(abs(body%c0(1) - own(1)) <= 1.0e-15_wp .and. abs(body%c0(2)) <= 0.0_wp, name//': first moment')
         call check_close(body%i0, sum(mass*(field%s - origin)**2), 1.0e-16_wp, name//': second moment')
         do j = 1, body%n
            own = 0.0_wp
            do i = 0, rod%elements
               p = [field%s(i) - origin, 0.0_wp]
               own(1:2) = own(1:2) + mass(i)*phi(:, j, i)
               own(3) = own(3) + mass(i)*dot_product(p, phi(:, j, i))
               own(4) = own(4) + mass(i)*(p(1)*phi(2, j, i) - p(2)*phi(1, j, i))
            end do
            scale = sqrt(body%mass)
            call check(maxval(abs(body%c(:, j) - own(1:2))) <= 1.0e-14_wp*scale, name//': C')
            call check(max(abs(body%d(j) - own(3)), abs(body%e(j) - own(4))) <= 1.0e-14_wp*scale*rod%length, name//': d and e')
            do k = 1, body%n
               product = 0.0_wp
               do i = 0, rod%elements
                  product(1) = product(1) + mass(i)*(phi(1, j, i)*phi(2, k, i) - phi(2, j, i)*phi(1, k, i))
                  product(2) = product(2) + mass(i)*dot_product(phi(:, j, i), phi(:, k, i))
               end do
               call check_close(body%skew(j, k), product(1), 1.0e-13_wp, name//': E')
               call check_close(product(2), merge(1.0_wp, 0.0_wp, j == k), 1.0e-11_wp, name//': D is the identity')
            end do
         end do
         call check(maxval(abs(body%skew(:4, 5:))) > 0.1_wp, name//': bending and axial coordinates couple')
         call check(maxval(abs(body%omega2 - [field%omega2_bending, field%omega2_axial])) <= 0.0_wp, name//': K_E')
         if (name == 'FREE-FREE') then
            call check(maxval(abs(body%c)) <= 1.0e-11_wp*sqrt(body%mass), name//': the centre of mass stays')
            call check(maxval(abs(body%e)) <= 1.0e-11_wp*sqrt(body%mass)*rod%length, name//': no angular momentum in the modes')
         end if
         deallocate (phi, mass)
      end do
   end subroutine test_invariants

   !> `modes` takes the lowest of both kinds together: for beams so stocky that they mix.
   subroutine test_lowest()
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field, all
      type(support_type) :: support
      type(error_type), allocatable :: error
      real(wp), allocatable :: omega2(:)
      integer :: modes, available(2), i, k
      do i = 1, size(names)
         support = new_support(trim(names(i)))
         beam = rod
         beam%elements = 7
         ! A radius of gyration of a sixteenth of the length: the second bending mode lies near the first axial one
         beam%ea = beam%ei*(16/beam%length)**2
         available = available_modes(beam, reduction_type(support=support))
         all = mesh_beam(beam)
         call bending_modes(beam, support, available(1), all, error)
         call check_no_error(error, names(i))
         call axial_modes(beam, support, available(2), all, error)
         call check_no_error(error, names(i))
         omega2 = sorted([all%omega2_bending, all%omega2_axial])
         do modes = 0, sum(available)
            choice = reduction_type(support=support, modes=modes, fidelity=fidelity_linear)
            call reduce_beam(beam, choice, body, field, error)
            call check_no_error(error, names(i))
            if (allocated(error)) cycle
            call check(body%n == modes, names(i)//': so many modes as asked for')
            call check(body%bending == count(all%omega2_bending <= omega2(max(1, modes))*(1 + 1.0e-9_wp)) .or. modes == 0, &
               & names(i)//': those in bending')
            call check(all_close(sorted(body%omega2), omega2(:modes)), names(i)//': they are the lowest')
         end do
         call check(any([(all%omega2_axial(1) < all%omega2_bending(k), k=1, 4)]), names(i)//': an axial mode among the lowest')
      end do
   end subroutine test_lowest

   pure logical function all_close(a, b)
      real(wp), intent(in) :: a(:), b(:)
      all_close = all(abs(a - b) <= 1.0e-9_wp*b)
   end function all_close

   pure function sorted(values) result(ascending)
      real(wp), intent(in) :: values(:)
      real(wp) :: ascending(size(values)), least
      integer :: i, j
      ascending = values
      do i = 1, size(values)
         j = i - 1 + minloc(ascending(i:), dim=1)
         least = ascending(j)
         ascending(j) = ascending(i)
         ascending(i) = least
      end do
   end function sorted

   !> Two elements, pinned and on a roller, have three modes; a fourth is an error that says so.
   subroutine test_too_many()
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      beam = rod
      beam%elements = 2
      choice = reduction_type(support=new_support('PINNED-ROLLER'), modes=3)
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, 'three modes')
      call check(body%n == 3 .and. body%bending == 1, 'one bending and two axial modes')
      choice%modes = 4
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a fourth mode is an error')
      if (allocated(error)) call check(index(error%message, 'gives 3 modes, 4 are asked for') > 0, 'the error has both numbers')
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1)
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a second bending mode is an error')
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=1, axial=3)
      call reduce_beam(beam, choice, body, field, error)
      call check(allocated(error), 'a third axial mode is an error')
   end subroutine test_too_many

   !> Shapes of a point: those of the node it stands on, and a rotation that is the slope of the deflection.
   subroutine test_point_shape()
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp), allocatable :: phi(:, :), psi(:), value(:, :), turn(:)
      real(wp) :: x, h
      integer :: i, k
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=3, axial=2, geometric_elements=4)
      call reduce_beam(rod, choice, body, field, error)
      call check_no_error(error, 'points')
      do i = 0, rod%elements
         call point_shape(field, field%s(i), phi, psi)
         call check(size(phi, 1) == 2 .and. size(phi, 2) == body%n .and. size(psi) == body%n, 'a column for each coordinate')
         call check(maxval(abs(phi(2, :3) - field%w(i, :))) <= 1.0e-13_wp*maxval(abs(field%w)), 'deflection of a node')
         call check(maxval(abs(phi(1, 4:) - field%u(i, :))) <= 1.0e-13_wp*maxval(abs(field%u)), 'extension of a node')
         call check(maxval(abs(psi(:3) - field%theta(i, :))) <= 1.0e-12_wp*maxval(abs(field%theta)), 'rotation of a node')
         call check(maxval(abs(phi(1, :3))) + maxval(abs(phi(2, 4:))) + maxval(abs(psi(4:))) <= 0.0_wp, &
            & 'bending moves across, axial coordinates along, and turn nothing')
      end do
      ! All places of the stencil lie in one element, where the deflection is a cubic
      x = 8.5_wp*rod%length/rod%elements
      h = 0.1_wp*rod%length/rod%elements
      allocate (value(body%n, -2:2))
      do k = -2, 2
         call point_shape(field, x + k*h, phi, turn)
         value(:, k) = phi(2, :)
      end do
      call point_shape(field, x, phi, psi)
      call check(maxval(abs(psi - derivative(value(:, -2), value(:, -1), value(:, 1), value(:, 2), h))) &
         & <= 1.0e-11_wp*maxval(abs(psi)), 'the rotation is the slope of the deflection')
   end subroutine test_point_shape

   !> A rigid body: Steiner.
   subroutine test_rigid()
      type(reduced_type) :: body
      body = rigid_reduced(3.0_wp, 0.5_wp, [2.0_wp, -1.0_wp])
      call check(body%n == 0 .and. body%bending == 0, 'a rigid body has no coordinates')
      call check_close(body%i0, 15.5_wp, 1.0e-14_wp, 'its moment about the origin')
      call check(maxval(abs(body%c0 - [6.0_wp, -3.0_wp])) <= 1.0e-15_wp, 'its first moment')
   end subroutine test_rigid

end program test_reduction
