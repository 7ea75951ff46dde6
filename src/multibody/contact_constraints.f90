!> Contacts of rigid stops as constraints: each keeps its scalar at the limit while it is closed. Floor: multibody. Source:
!> doc/theory, eq. (5.85).
module limber_multibody_contact_constraints
   use limber_base_kinds, only: wp
   use limber_model_model, only: along_angle, along_distance
   use limber_multibody_constraint, only: constraint_type
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_function_sums, only: add_section_angle, add_distance, add_scalar, find_bodies
   use limber_multibody_marker_registry, only: registry_type, marker_of, direction_of
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_along
   implicit none
   private
   public :: contact_constraint_type, new_contact

   !> A type of its own: it is neither a joint nor a driver, and no body hangs on it
   type, extends(linear_type) :: contact_constraint_type
   end type contact_constraint_type

contains

   !> The constraint of a contact of the model: the scalar of its stop is the limit.
   subroutine new_contact(system, index, item)
      class(registry_type), intent(inout) :: system
      !> Of the contact in the model
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      type(contact_constraint_type) :: contact
      real(wp) :: guess
      integer :: k
      guess = 0.0_wp
      associate (load => system%model%loads(system%model%contacts(index)%load))
         associate (part => system%model%load_parts(load%first))
            select case (part%along)
            case (along_angle)
               call add_section_angle(system, contact%linear_type, part%points(1), 1.0_wp, guess)
               call add_section_angle(system, contact%linear_type, part%points(2), -1.0_wp, guess)
            case (along_distance)
               call add_distance(system, contact%linear_type, part%points, 1)
               contact%scale = system%model%length
            case default
               call add_scalar(contact%linear_type, scalar_function_type(kind=scalar_along, markers=[marker_of(system, &
                  & part%points(1)), marker_of(system, part%points(2)), direction_of(system, part%points(2), part%angle)], &
                  & unit=.true.), 1.0_wp, 1)
               contact%scale = system%model%length
            end select
            call find_bodies(system, contact%linear_type)
            do k = 1, 2
               where (contact%bodies == system%model%points(part%points(k))%body) contact%points = part%points(k)
            end do
         end associate
         contact%label = "stop '"//load%name//"'"
      end associate
      contact%offset(1) = system%model%contacts(index)%limit
      allocate (item, source=contact)
   end subroutine new_contact

end module limber_multibody_contact_constraints
